#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace tandem::orchestrator {

/// Folder of one run: `runs/<scenario>/<UTC time>/`, or what the user says.
///   scenario.yaml  resolved, complete, rerunnable     exchange.lcm  every exchange, LCM event log
///   steps.csv      one row per macro step             ports.csv     accepted motions and wrenches
///   bodies.csv     every rigid body                   fem/*.vtu     for ParaView
///   energy.csv     both sides' energy books, when output.energy_every_steps is set
///   mbs.log, fem.log   what the processes said        summary.json  the numbers of the run
///   bus.json       where a run over LCM is heard: run id, port, ttl
class RunDirectory {
 public:
  /// Creates the folder for this process alone: a folder that already holds a run, or that another
  /// command writes into, is refused when the user named it, and avoided by a suffix when it is the
  /// default. It is kept from others until the last copy of the object ends.
  static RunDirectory create(const std::optional<std::filesystem::path>& chosen,
                             const std::string& scenario_name);
  /// A folder for several runs, `runs/<scenario>/<purpose>-<UTC time>/` or the chosen one.
  static RunDirectory create_group(const std::optional<std::filesystem::path>& chosen,
                                   const std::string& scenario_name, const std::string& purpose);
  /// The folder emptied, or made; refused while another command writes into it.
  static RunDirectory create_anew(const std::filesystem::path& path);
  /// An existing run; throws a Usage error that says what is missing.
  static RunDirectory open(const std::filesystem::path& path);

  [[nodiscard]] const std::filesystem::path& path() const { return path_; }
  [[nodiscard]] std::filesystem::path scenario() const { return path_ / "scenario.yaml"; }
  [[nodiscard]] std::filesystem::path log() const { return path_ / "exchange.lcm"; }
  [[nodiscard]] std::filesystem::path summary() const { return path_ / "summary.json"; }
  [[nodiscard]] std::filesystem::path bus() const { return path_ / "bus.json"; }
  [[nodiscard]] std::filesystem::path process_log(const std::string& side) const {
    return path_ / (side + ".log");
  }

 private:
  class Claim;
  explicit RunDirectory(std::filesystem::path path) : path_(std::move(path)) {}
  static RunDirectory claimed(const std::optional<std::filesystem::path>& chosen,
                              const std::string& scenario_name, const std::string& prefix);
  std::filesystem::path path_;
  std::shared_ptr<const Claim> claim_;
};

}  // namespace tandem::orchestrator
