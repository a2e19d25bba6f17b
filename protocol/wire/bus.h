#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "protocol/wire/process_names.h"
#include "protocol/wire/receiver.h"
#include "protocol/wire/seal.h"

namespace tandem::wire {

struct BusOptions {
  Process self = Process::Tool;
  std::uint64_t run_id = 0;
  int port = 0;  ///< private to the run; free_port()
  ProcessNames names;
  int ttl = 0;  ///< 0 = this host only, 1 = one subnet
  int receive_buffer_bytes = 4194304;
  Receive receive = Receive::Own;
  Wait wait = Wait::Block;   ///< of Receive::Own
  double self_test_s = 2.0;  ///< longest time to hear the own test message at opening
};

/// A random run id.
[[nodiscard]] std::uint64_t random_run_id();

/// What came and went since the bus was opened.
struct BusCounts {
  std::int64_t messages_out = 0;
  std::int64_t bytes_out = 0;
  std::int64_t send_errors = 0;
  std::int64_t messages_in = 0;  ///< of this run, for this process, undamaged
  std::int64_t bytes_in = 0;
  std::int64_t damaged = 0;      ///< checksum wrong
  std::int64_t undecodable = 0;  ///< seal good, content not of this schema
  std::int64_t foreign = 0;      ///< of another run or program
};

/// What a publish cost.
struct Sent {
  std::int64_t messages = 0;
  std::int64_t bytes = 0;
};

class Bus;

/// Keeps a handler in place; ends with the object that owns it.
class Subscription {
 public:
  Subscription() = default;
  Subscription(Bus& bus, std::string channel) : bus_(&bus), channel_(std::move(channel)) {}
  Subscription(Subscription&& other) noexcept { swap(other); }
  Subscription& operator=(Subscription&& other) noexcept {
    swap(other);
    return *this;
  }
  ~Subscription();

 private:
  void swap(Subscription& other) {
    std::swap(bus_, other.bus_);
    std::swap(channel_, other.channel_);
  }
  Bus* bus_ = nullptr;
  std::string channel_;
};

/// One process's connection to the multicast of a run: sends through liblcm, receives through a
/// Receiver. Channels are TANDEM_<run id>_<topic>_<kind>: letters, digits and '_' only,
/// since LCM subscriptions are regular expressions. Messages beyond kMaxWhole travel in chunks: as
/// many at once as the receive buffer holds, which has the same size in all processes of a host;
/// then those that the receiver says it lacks. A repetition is one chunk.
///
/// Nothing is received but within pump(): one thread owns the bus; publish() of a message that fits
/// one datagram may also be called from others. Messages may be lost, repeated or reordered; the
/// layers above cope.
class Bus {
 public:
  using Handler = std::function<void(const Header&, ByteView message)>;

  /// Opens and hears itself once. Throws tandem::Error with the remedy when it cannot: no route,
  /// port taken, multicast filtered by a firewall.
  explicit Bus(const BusOptions& options);
  ~Bus();
  Bus(const Bus&) = delete;
  Bus& operator=(const Bus&) = delete;

  /// Seals and sends. `topic` is the process that the message is about or for. A send error is
  /// counted and kept (send_error()): to the layers above it is a lost message.
  Sent publish(Process topic, Kind kind, Bytes& message, std::int32_t attempt = 0);

  /// Calls `handler` for messages of this channel; at most one handler per channel.
  [[nodiscard]] Subscription subscribe(Process topic, Kind kind, Handler handler);

  /// Waits up to `timeout_s` for a datagram and handles it. False when none came.
  bool pump(double timeout_s);

  /// now_s() at which the datagram came in that is being handled.
  [[nodiscard]] double arrival_s() const;

  /// The message that is being handled, to be kept: without a copy when it came in chunks. Its
  /// bytes may be written to.
  [[nodiscard]] std::shared_ptr<Bytes> share(ByteView message) const;

  /// A header for a message of this process; sequence numbers are the caller's.
  [[nodiscard]] Header header(Kind kind, std::int64_t sequence = 0) const;

  [[nodiscard]] std::string name_of(Process process) const { return options().names.name(process); }
  [[nodiscard]] std::string program_of(Process process) const {
    return options().names.program(process);
  }
  [[nodiscard]] const BusOptions& options() const;
  [[nodiscard]] BusCounts counts() const;
  [[nodiscard]] int receive_buffer_bytes() const;  ///< what the kernel granted
  [[nodiscard]] std::string send_error() const;    ///< last one, empty = none

  /// Number of good messages heard from each process.
  [[nodiscard]] const std::array<std::int64_t, kProcesses>& heard() const;

  /// Called by handlers for a message whose content they cannot decode.
  void count_undecodable();

 private:
  friend class Subscription;
  void self_test();
  void narrow();
  void send_missing(ByteView message);
  void ask_for_missing();
  [[nodiscard]] std::size_t burst() const;
  struct State;
  std::unique_ptr<State> state_;
  Subscription missing_;  // ends before the state that it is kept in
};

}  // namespace tandem::wire
