#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "protocol/driver/placement.h"
#include "protocol/driver/wire_params.h"

namespace tandem::orchestrator {

/// One line of the exchange benchmark.
struct ExchangeCase {
  int nodes = 1;  ///< ports: as many motions there as wrenches back
  Placement placement = Placement::Same;
  DriverPlace driver = DriverPlace::Mbs;  ///< direct exchange, or through the hub
  wire::Receive receive = wire::Receive::Own;
  wire::Wait wait = wire::Wait::Adaptive;
  int blocks = 20;     ///< of each kind of round trip, in turn
  int per_block = 50;  ///< round trips in a block
};

/// Every single round trip of a benchmark (µs).
struct ExchangeSamples {
  std::vector<double> raw_tcp_us;   ///< as many bytes as the motions there and the wrenches back
  std::vector<double> raw_udp_us;   ///< the same
  std::vector<double> exchange_us;  ///< from motions in memory to wrenches in memory
  std::vector<double> record_us;    ///< journal of the step: encoding, sending, waiting for credit
  std::vector<double> step_us;      ///< the whole macro step, with mock sides that compute nothing
  std::int64_t resent = 0;
};

/// Runs tandem's explicit exchange between processes of its own, with checksum, ledger, heartbeats
/// and a recorder that writes exchange.lcm, on mock sides without solvers. In turn with it, between
/// the same two processes: TCP (NODELAY) and UDP ping-pongs over 127.0.0.1. Throws tandem::Error
/// when a process fails; leaves no process and no file behind.
[[nodiscard]] ExchangeSamples measure_exchange(const ExchangeCase& which);

}  // namespace tandem::orchestrator
