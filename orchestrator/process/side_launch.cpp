#include "orchestrator/process/side_launch.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>

#include "orchestrator/process/interruption.h"
#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

ErrorKind kind_of(const ExitStatus& status) {
  if (status.code == 2) return ErrorKind::Usage;
  if (status.code == 3) return ErrorKind::NotSolved;
  return ErrorKind::Partner;
}

}  // namespace

SideLaunch::SideLaunch(const std::vector<wire::Process>& sides, const wire::ProcessNames& names,
                       const RunDirectory& directory, std::uint64_t run_id, int port, bool attach,
                       bool silent)
    : silent_(silent) {
  for (wire::Process side : sides) {
    const std::string executable = wire::ProcessNames::executable(side);
    std::vector<std::string> arguments{
        "--scenario", directory.scenario().string(), "--run", fmt::format("{:016x}", run_id),
        "--port",     std::to_string(port),          "--dir", directory.path().string()};
    if (static_cast<std::size_t>(side) >= wire::kFirstBody) {
      arguments.insert(arguments.end(),
                       {wire::is_multibody(side) ? "--world" : "--body", names.name(side)});
    }
    if (attach) {
      std::fprintf(stderr, "start by hand: %s %s\n", executable.c_str(),
                   fmt::format("{}", fmt::join(arguments, " ")).c_str());
      continue;
    }
    arguments.insert(arguments.end(), {"--parent", std::to_string(getpid())});
    const auto log = directory.process_log(names.name(side));
    children_.push_back(std::unique_ptr<Child>(
        new Child{side, ChildProcess(names.program(side), find_program(executable), arguments, log),
                  LogTail(names.name(side), log)}));
  }
}

SideLaunch::~SideLaunch() {
  for (const auto& child : children_) child->process.end(0.0);
}

void SideLaunch::supervise(const std::vector<wire::Process>& needed) {
  throw_if_interrupted();
  for (const auto& child : children_) {
    if (!silent_) child->tail.forward();
    const auto status = child->process.poll();
    if (!status) continue;
    if (status->code != 0) {
      throw Error(kind_of(*status),
                  fmt::format("{} ended: {}", child->process.name(), status->text()));
    }
    if (std::find(needed.begin(), needed.end(), child->side) != needed.end()) {
      throw Error(ErrorKind::Partner, fmt::format("{} ended with exit code 0 before the run was "
                                                  "over",
                                                  child->process.name()));
    }
  }
}

bool SideLaunch::started(wire::Process side) const {
  return std::any_of(children_.begin(), children_.end(),
                     [side](const auto& child) { return child->side == side; });
}

std::optional<ExitStatus> SideLaunch::ended(wire::Process side) {
  for (const auto& child : children_) {
    if (child->side == side) return child->process.poll();
  }
  return std::nullopt;
}

std::string SideLaunch::fate(const Child& child, const ExitStatus& status) const {
  // Its own words, unless they have been forwarded.
  const std::string said = status.code != 0 && silent_ ? child.tail.last_line() : "";
  return fmt::format("{}: {}{}{}; see {}", child.process.name(), status.text(),
                     said.empty() ? "" : ": ", said, child.process.log().string());
}

std::vector<std::string> SideLaunch::left_in_peace() {
  std::vector<std::string> phrases;
  for (const auto& child : children_) {
    const auto status = child->process.poll();
    if (status && status->code == 0) phrases.push_back(fate(*child, *status));
  }
  return phrases;
}

std::vector<std::string> SideLaunch::end_all(double patience_s) {
  std::vector<std::string> phrases;
  const double deadline_s = now_s() + patience_s;
  for (const auto& child : children_) {
    const bool in_time = child->process.poll().has_value() || deadline_s > now_s();
    const ExitStatus status = child->process.end(in_time ? deadline_s - now_s() : 0.0);
    if (!silent_) child->tail.forward();
    if (status.code != 0) phrases.push_back(fate(*child, status));
  }
  return phrases;
}

}  // namespace tandem::orchestrator
