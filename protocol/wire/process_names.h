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
  /// Of a run with these flexible bodies; one has no name of its own here.
  explicit ProcessNames(std::vector<std::string> bodies) : bodies_(std::move(bodies)) {}

  /// "mbs", "fem", "conrod": begins what a process says.
  [[nodiscard]] std::string name(Process process) const {
    const std::string* body = body_of(process);
    return body == nullptr ? text_of(process) : *body;
  }
  /// "tandem-mbs", "tandem-fem", "tandem-fem conrod": in what is said of it.
  [[nodiscard]] std::string program(Process process) const {
    if (process == Process::Orchestrator) return "tandem (the orchestrator)";
    if (process == Process::Tool) return "a tool";
    const std::string* body = body_of(process);
    return executable(process) + (body == nullptr ? "" : " " + *body);
  }
  /// The program of a side: "tandem-fem".
  [[nodiscard]] static std::string executable(Process side) {
    return side == Process::Mbs ? "tandem-mbs" : "tandem-fem";
  }

  [[nodiscard]] std::size_t bodies() const { return bodies_.size(); }

 private:
  [[nodiscard]] const std::string* body_of(Process process) const {
    const auto number = static_cast<std::size_t>(process);
    const bool is_one = number >= kFirstBody && number - kFirstBody < bodies_.size();
    return is_one ? &bodies_[number - kFirstBody] : nullptr;
  }

  std::vector<std::string> bodies_;
};

}  // namespace tandem::wire
