#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "protocol/wire/seal.h"

namespace tandem::wire {

/// What people call the processes of a run.
class ProcessNames {
 public:
  ProcessNames() = default;
  /// Of a run with these flexible bodies and these multibody worlds; one has no name of its own
  /// here.
  explicit ProcessNames(std::vector<std::string> bodies, std::vector<std::string> worlds = {})
      : bodies_(std::move(bodies)), worlds_(std::move(worlds)) {}

  /// "mbs", "fem", "conrod": begins what a process says.
  [[nodiscard]] std::string name(Process process) const {
    const std::string* own = own_name(process);
    return own == nullptr ? text_of(process) : *own;
  }
  /// "tandem-mbs", "tandem-fem", "tandem-fem conrod": in what is said of it.
  [[nodiscard]] std::string program(Process process) const {
    if (process == Process::Orchestrator) return "tandem (the orchestrator)";
    if (process == Process::Tool) return "a tool";
    const std::string* own = own_name(process);
    return executable(process) + (own == nullptr ? "" : " " + *own);
  }
  /// The program of a side: "tandem-fem".
  [[nodiscard]] static std::string executable(Process side) {
    return is_multibody(side) ? "tandem-mbs" : "tandem-fem";
  }

  /// Whether the run has several flexible bodies or several worlds.
  [[nodiscard]] bool several() const { return bodies_.size() + worlds_.size() > 1; }

  /// One more than the greatest number that a process of the run has.
  [[nodiscard]] std::size_t processes() const {
    return worlds_.empty() ? kFirstBody + bodies_.size() : kFirstWorld + worlds_.size();
  }

 private:
  [[nodiscard]] const std::string* own_name(Process process) const {
    const auto number = static_cast<std::size_t>(process);
    const std::string* body = at(bodies_, number, kFirstBody);
    return body == nullptr ? at(worlds_, number, kFirstWorld) : body;
  }
  [[nodiscard]] static const std::string* at(const std::vector<std::string>& names,
                                             std::size_t number, std::size_t first) {
    const bool is_one = number >= first && number - first < names.size();
    return is_one ? &names[number - first] : nullptr;
  }

  std::vector<std::string> bodies_;
  std::vector<std::string> worlds_;
};

}  // namespace tandem::wire
