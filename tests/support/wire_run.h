#pragma once

#include <memory>
#include <random>
#include <string>
#include <vector>

#include "protocol/wire/multicast_socket.h"
#include "tests/support/child_process.h"

namespace tandem::test {

/// A run of wire_peer processes on a port of its own.
struct PeerRun {
  std::string run = "run=" + std::to_string(std::random_device{}());
  std::string port = "port=" + std::to_string(wire::free_port());
  Environment faults;

  [[nodiscard]] std::unique_ptr<ChildProcess> start(const std::string& role,
                                                    std::vector<std::string> more = {}) const {
    std::vector<std::string> command{TANDEM_BIN_DIR "/wire_peer", role, run, port};
    command.insert(command.end(), more.begin(), more.end());
    Environment environment = faults;
    // A preloaded library comes before a sanitizer's runtime; it does not use it.
    environment["ASAN_OPTIONS"] = "verify_asan_link_order=0";
    return std::make_unique<ChildProcess>(command, environment);
  }
};

}  // namespace tandem::test
