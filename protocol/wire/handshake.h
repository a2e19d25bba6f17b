#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "protocol/wire/bus.h"
#include "protocol/wire/liveness.h"
#include "protocol/wire/messages.h"

namespace tandem::wire {

/// What the process that says hello expects of the one that answers.
struct RemoteOptions {
  Process side = Process::Fem;  ///< Mbs, Fem or one of several worlds or bodies
  std::uint64_t scenario_hash = 0;
  std::vector<std::string> port_names;
  std::string tandem_version;
};

/// Says hello until the side says welcome, for `timeout_s` at most. Throws tandem::Error: Usage
/// when it is of another version, scenario or port table, Partner when it lives and does not
/// answer.
Handshake greet(Bus& bus, LivenessMonitor& monitor, const RemoteOptions& options, double timeout_s);

/// The other end: answers every hello, as long as it lives, since an answer may be lost.
class HelloServer {
 public:
  HelloServer(Bus& bus, const SubsystemInfo& info, std::uint64_t scenario_hash,
              std::string tandem_version);

  /// Whether a hello has come that fits, and why one was refused; empty = none was.
  [[nodiscard]] bool greeted() const { return greeted_; }
  [[nodiscard]] const std::string& refusal() const { return refusal_; }
  [[nodiscard]] const Bus& bus() const { return bus_; }

 private:
  void on_hello(ByteView message);
  [[nodiscard]] std::string mismatch(const Handshake& hello) const;

  Bus& bus_;
  const SubsystemInfo& info_;
  std::uint64_t scenario_hash_;
  std::string tandem_version_;
  bool greeted_ = false;
  std::string refusal_;
  Subscription hellos_;
};

/// Waits until the orchestrator has said hello to `server`, for `timeout_s` at most: a driver makes
/// no step for one that may be of another build. Throws tandem::Error as greet() does.
void await_hello(const HelloServer& server, LivenessMonitor& monitor, double timeout_s);

}  // namespace tandem::wire
