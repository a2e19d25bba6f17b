#include "protocol/wire/bus.h"

#include <fmt/format.h>
#include <lcm/lcm.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <map>
#include <mutex>
#include <random>
#include <utility>
#include <vector>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"
#include "protocol/wire/chunks.h"
#include "protocol/wire/chunks_sent.h"
#include "protocol/wire/lcm_receiver.h"
#include "protocol/wire/loopback_route.h"
#include "protocol/wire/multicast_socket.h"

namespace tandem::wire {
namespace {

// Parts of a burst follow each other at once: after this the rest of it is lost.
constexpr double kQuiet_s = 0.002;

struct LcmDestroy {
  void operator()(lcm_t* lcm) const { lcm_destroy(lcm); }
};

}  // namespace

struct Bus::State {
  explicit State(const BusOptions& given)
      : options(given),
        filter{.prefix = fmt::format("TANDEM_{:016x}_", given.run_id), .channels = {}} {
    const ReceiverOptions listening{given.port, given.ttl, given.receive_buffer_bytes, given.wait};
    if (given.receive == Receive::Lcm) {
      receiver = std::make_unique<LcmReceiver>(listening);
    } else {
      auto own = std::make_unique<MulticastSocket>(listening);
      socket = own.get();
      receiver = std::move(own);
    }
    for (std::size_t topic = 0; topic < given.names.processes(); ++topic) {
      auto& own = channels.emplace_back();
      for (std::size_t kind = 0; kind < kKinds; ++kind) {
        own[kind] = filter.prefix + text_of(static_cast<Process>(topic)) + "_" +
                    text_of(static_cast<Kind>(kind));
      }
    }
  }

  [[nodiscard]] const std::string& channel(Process topic, Kind kind) const {
    return channels.at(static_cast<std::size_t>(topic))[static_cast<std::size_t>(kind)];
  }
  void send(const std::string& channel, ByteView message);
  void handle(const Datagram& incoming);
  void handle_chunk(std::string_view channel, ByteView message);
  std::int64_t send_part(SentMessages::Entry& entry, std::size_t index, bool ends_burst,
                         std::int32_t attempt);
  void dispatch(const Header& header, std::string_view channel, ByteView message);

  BusOptions options;
  ChannelFilter filter;
  std::vector<std::array<std::string, kKinds>> channels;  ///< by process
  std::unique_ptr<Receiver> receiver;
  MulticastSocket* socket = nullptr;  // the receiver, when it can filter
  LoopbackRoute loopback;
  std::unique_ptr<lcm_t, LcmDestroy> lcm;  // publishes only: no thread, no self test of its own
  std::map<std::string, Handler, std::less<>> handlers;
  SentMessages sent;
  Assembler assembler;
  bool asks_when_quiet = false;  // the message of the last chunk is not whole
  bool burst_ended = false;      // … and no more of it comes before it is asked for
  BusCounts counts;
  Datagram datagram;  // the one being handled
  double arrival_s = 0.0;
  std::array<std::int64_t, kProcesses> heard{};
  std::atomic<std::int64_t> messages_out{0}, bytes_out{0}, send_errors{0};
  mutable std::mutex error_mutex;
  std::string send_error;
};

Subscription::~Subscription() {
  if (bus_ != nullptr) bus_->state_->handlers.erase(channel_);
}

std::uint64_t random_run_id() {
  std::random_device random;
  return (static_cast<std::uint64_t>(random()) << 32U) | random();
}

Bus::Bus(const BusOptions& options) : state_(std::make_unique<State>(options)) {
  const std::string url = fmt::format("udpm://{}:{}?ttl={}", kGroup, options.port, options.ttl);
  state_->lcm.reset(lcm_create(url.c_str()));
  require(state_->lcm != nullptr, fmt::format("wire: liblcm cannot open {}", url));
  if (options.ttl == 0) state_->loopback.apply();
  self_test();
  missing_ = subscribe(options.self, Kind::Missing,
                       [this](const Header&, ByteView message) { send_missing(message); });
}

Bus::~Bus() = default;

void Bus::self_test() {
  // Every process of a run tests on its own: the sequence number says whose message it is.
  const auto nonce = static_cast<std::int64_t>(random_run_id() >> 1U);
  bool heard = false;
  const Subscription subscription =
      subscribe(state_->options.self, Kind::SelfTest, [&](const Header& header, ByteView) {
        if (header.sequence != nonce || heard) return;
        heard = true;
        state_->filter.own_address = state_->datagram.from_address;
        state_->filter.own_port = state_->datagram.from_port;
      });
  const double end_s = now_s() + state_->options.self_test_s;
  double send_s = 0.0;
  while (!heard) {
    const double time_s = now_s();
    if (time_s > end_s) {
      // On a busy machine it may lie behind other messages: those first.
      if (pump(0.0)) continue;
      throw Error(
          ErrorKind::Usage,
          fmt::format("wire: {} does not hear its own messages on udp {}:{} within {:.1f} "
                      "s{}. A firewall filters multicast or its route leads nowhere: accept "
                      "udp to {} and, on one host, `ip route add 224.0.0.0/4 dev lo`.",
                      program_of(state_->options.self), kGroup, state_->options.port,
                      state_->options.self_test_s,
                      send_error().empty() ? "" : " (sending: " + send_error() + ")", kGroup));
    }
    if (time_s >= send_s) {
      Bytes message = encode(Credit{header(Kind::SelfTest, nonce), 0, 0});
      publish(state_->options.self, Kind::SelfTest, message);
      send_s = time_s + 0.05;
    }
    pump(0.05);
  }
}

void Bus::narrow() {
  if (state_->socket == nullptr) return;
  state_->filter.channels.clear();
  for (const auto& [channel, handler] : state_->handlers)
    state_->filter.channels.push_back(channel);
  state_->socket->attach(state_->filter);
}

Header Bus::header(Kind kind, std::int64_t sequence) const {
  Header header;
  header.run_id = state_->options.run_id;
  header.kind = kind;
  header.sequence = sequence;
  header.sender = state_->options.self;
  return header;
}

void Bus::State::send(const std::string& channel, ByteView message) {
  const auto size = static_cast<unsigned>(message.size());
  int result = -1;
  do {
    errno = 0;
    result = lcm_publish(lcm.get(), channel.c_str(), message.data(), size);
  } while (result != 0 && errno == EINTR);
  messages_out.fetch_add(1, std::memory_order_relaxed);
  bytes_out.fetch_add(size, std::memory_order_relaxed);
  if (result == 0) return;
  send_errors.fetch_add(1, std::memory_order_relaxed);
  const int error = errno;
  const std::lock_guard lock(error_mutex);
  send_error = fmt::format("{} bytes on {}: {}", size, channel, std::strerror(error));
}

Sent Bus::publish(Process topic, Kind kind, Bytes& message, std::int32_t attempt) {
  if (message.size() <= kMaxWhole) {
    seal(message, attempt);
    state_->send(state_->channel(topic, kind), message);
    return {1, static_cast<std::int64_t>(message.size())};
  }
  Sent sent;
  SentMessages::Entry& entry = state_->sent.keep(state_->channel(topic, kind), message);
  // A repetition need not bring anything but the receiver's word of what it lacks.
  const std::size_t count = attempt > 0 ? 1 : std::min(entry.message.parts(), burst());
  for (std::size_t i = 0; i < count; ++i) {
    const std::int64_t bytes = state_->send_part(entry, i, i + 1 == count, attempt);
    ++sent.messages;
    sent.bytes += bytes;
  }
  return sent;
}

std::int64_t Bus::State::send_part(SentMessages::Entry& entry, std::size_t index, bool ends_burst,
                                   std::int32_t attempt) {
  std::int64_t bytes = 0;
  entry.message.send(index, ends_burst, attempt, [&](ByteView part) {
    bytes = static_cast<std::int64_t>(part.size());
    send(entry.channel, part);
  });
  return bytes;
}

void Bus::send_missing(ByteView message) {
  const auto missing = decode_missing(message);
  if (!missing) return count_undecodable();
  SentMessages::Entry* entry = state_->sent.find(*missing);
  if (entry == nullptr) return;  // its repetition brings it back
  std::vector<std::size_t> parts;
  for (const std::int32_t index : missing->wanted) {
    const bool is_one = index >= 0 && static_cast<std::size_t>(index) < entry->message.parts();
    if (is_one && parts.size() < burst()) parts.push_back(static_cast<std::size_t>(index));
  }
  for (const std::size_t part : parts) state_->send_part(*entry, part, part == parts.back(), 1);
}

void Bus::ask_for_missing() {
  state_->asks_when_quiet = false;
  auto request = state_->assembler.lacks(burst());
  if (!request) return;
  const std::int64_t sequence = request->missing.header.sequence;
  request->missing.header = header(Kind::Missing, sequence);
  Bytes message = encode(request->missing);
  publish(request->sender, Kind::Missing, message);
}

std::size_t Bus::burst() const { return burst_of(state_->receiver->receive_buffer_bytes()); }

Subscription Bus::subscribe(Process topic, Kind kind, Handler handler) {
  const std::string& channel = state_->channel(topic, kind);
  if (!state_->handlers.emplace(channel, std::move(handler)).second) {
    throw std::logic_error("wire: two handlers for channel " + channel);
  }
  narrow();
  return {*this, channel};
}

bool Bus::pump(double timeout_s) {
  const double quiet_s = state_->asks_when_quiet ? std::min(timeout_s, kQuiet_s) : timeout_s;
  if (!state_->receiver->receive(quiet_s, state_->datagram)) {
    if (state_->asks_when_quiet && timeout_s > 0.0) ask_for_missing();
    return false;
  }
  state_->arrival_s = now_s();
  state_->handle(state_->datagram);
  if (std::exchange(state_->burst_ended, false)) ask_for_missing();
  return true;
}

void Bus::State::handle(const Datagram& incoming) {
  if (!incoming.channel.starts_with(filter.prefix)) {
    ++counts.foreign;
    return;
  }
  if (handlers.find(incoming.channel) == handlers.end()) return;  // not for this process
  const auto header = open_seal(incoming.payload);
  if (!header) {
    ++counts.damaged;
    return;
  }
  // An old message put on a channel of this run still carries the old run's id.
  if (header->run_id != options.run_id) {
    ++counts.foreign;
    return;
  }
  if (header->kind == Kind::Chunk) {
    handle_chunk(incoming.channel, incoming.payload);
  } else {
    dispatch(*header, incoming.channel, incoming.payload);
  }
}

void Bus::State::handle_chunk(std::string_view channel, ByteView message) {
  const auto chunk = decode_chunk(message);
  if (!chunk || !channel.ends_with(text_of(chunk->whole_kind))) {
    ++counts.undecodable;
    return;
  }
  ++heard[static_cast<std::size_t>(chunk->header.sender)];
  const auto whole = assembler.add(*chunk);
  asks_when_quiet = !whole;
  burst_ended = !whole && chunk->ends_burst;
  if (!whole) return;
  const Header header = header_of(*whole);
  if (header.run_id != options.run_id || header.sender != chunk->header.sender) {
    ++counts.undecodable;
    return;
  }
  dispatch(header, channel, *whole);
}

void Bus::State::dispatch(const Header& header, std::string_view channel, ByteView message) {
  const auto found = handlers.find(channel);
  if (!channel.ends_with(text_of(header.kind))) {
    ++counts.undecodable;
    return;
  }
  ++counts.messages_in;
  counts.bytes_in += static_cast<std::int64_t>(message.size());
  ++heard[static_cast<std::size_t>(header.sender)];
  const Handler handler = found->second;  // a copy: the handler may end its own subscription
  handler(header, message);
}

std::shared_ptr<Bytes> Bus::share(ByteView message) const {
  const std::shared_ptr<Bytes>& whole = state_->assembler.whole();
  if (whole && whole->data() == message.data() && whole->size() == message.size()) return whole;
  return std::make_shared<Bytes>(message.begin(), message.end());
}

double Bus::arrival_s() const { return state_->arrival_s; }

const BusOptions& Bus::options() const { return state_->options; }

BusCounts Bus::counts() const {
  BusCounts counts = state_->counts;
  counts.messages_out = state_->messages_out.load(std::memory_order_relaxed);
  counts.bytes_out = state_->bytes_out.load(std::memory_order_relaxed);
  counts.send_errors = state_->send_errors.load(std::memory_order_relaxed);
  return counts;
}

int Bus::receive_buffer_bytes() const { return state_->receiver->receive_buffer_bytes(); }

std::string Bus::send_error() const {
  const std::lock_guard lock(state_->error_mutex);
  return state_->send_error;
}

const std::array<std::int64_t, kProcesses>& Bus::heard() const { return state_->heard; }

void Bus::count_undecodable() { ++state_->counts.undecodable; }

}  // namespace tandem::wire
