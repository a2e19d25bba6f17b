#include "protocol/wire/bus.h"

#include <fmt/format.h>
#include <lcm/lcm.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <map>
#include <mutex>
#include <random>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"
#include "protocol/wire/chunks.h"

namespace tandem::wire {
namespace {

struct LcmDestroy {
  void operator()(lcm_t* lcm) const { lcm_destroy(lcm); }
};

}  // namespace

struct Bus::State {
  explicit State(const BusOptions& given)
      : options(given),
        prefix(fmt::format("TANDEM_{:016x}_", given.run_id)),
        socket(given.port, given.receive_buffer_bytes) {}

  std::string channel(Process topic, Kind kind) const {
    return prefix + text_of(topic) + "_" + text_of(kind);
  }
  void send(const std::string& channel, const Bytes& message);
  void handle(const Datagram& incoming);
  void handle_chunk(const Header& header, std::string_view channel, ByteView message);
  void dispatch(const Header& header, std::string_view channel, ByteView message);

  BusOptions options;
  std::string prefix;
  MulticastSocket socket;
  std::unique_ptr<lcm_t, LcmDestroy> lcm;  // publishes only: no thread, no self test of its own
  std::map<std::string, Handler, std::less<>> handlers;
  Assembler assembler;
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
  self_test();
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
        const Datagram& own = state_->datagram;
        state_->socket.ignore_sender(own.from_address, own.from_port);
      });
  const double end_s = now_s() + state_->options.self_test_s;
  double send_s = 0.0;
  while (!heard) {
    const double time_s = now_s();
    if (time_s > end_s) {
      throw Error(
          ErrorKind::Usage,
          fmt::format("wire: {} does not hear its own messages on udp {}:{} within {:.1f} "
                      "s{}. A firewall filters multicast or its route leads nowhere: accept "
                      "udp to {} and, on one host, `ip route add 224.0.0.0/4 dev lo`.",
                      executable_of(state_->options.self), kGroup, state_->options.port,
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

Header Bus::header(Kind kind, std::int64_t sequence) const {
  Header header;
  header.run_id = state_->options.run_id;
  header.kind = kind;
  header.sequence = sequence;
  header.sender = state_->options.self;
  return header;
}

void Bus::State::send(const std::string& channel, const Bytes& message) {
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
  // A repetition has the same bytes, so that its chunks fill the gaps of earlier ones.
  seal(message, 0);
  Sent sent;
  for (const Bytes& part : cut(message, attempt)) {
    state_->send(state_->channel(topic, Kind::Chunk), part);
    ++sent.messages;
    sent.bytes += static_cast<std::int64_t>(part.size());
  }
  return sent;
}

Subscription Bus::subscribe(Process topic, Kind kind, Handler handler) {
  std::string channel = state_->channel(topic, kind);
  if (!state_->handlers.emplace(channel, std::move(handler)).second) {
    throw std::logic_error("wire: two handlers for channel " + channel);
  }
  return {*this, std::move(channel)};
}

bool Bus::pump(double timeout_s) {
  if (!state_->socket.receive(timeout_s, state_->datagram)) return false;
  state_->arrival_s = now_s();
  state_->handle(state_->datagram);
  return true;
}

void Bus::State::handle(const Datagram& incoming) {
  if (!incoming.channel.starts_with(prefix)) {
    ++counts.foreign;
    return;
  }
  const bool chunk = incoming.channel.ends_with("_chunk");
  if (!chunk && handlers.find(incoming.channel) == handlers.end()) return;  // not for this process
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
  if (chunk) {
    handle_chunk(*header, incoming.channel, incoming.payload);
  } else {
    dispatch(*header, incoming.channel, incoming.payload);
  }
}

void Bus::State::handle_chunk(const Header& header, std::string_view channel, ByteView message) {
  const auto chunk = decode_chunk(message);
  if (!chunk || header.kind != Kind::Chunk) {
    ++counts.undecodable;
    return;
  }
  std::string whole_channel(channel.substr(0, channel.size() - std::strlen("chunk")));
  whole_channel += text_of(chunk->whole_kind);
  if (handlers.find(whole_channel) == handlers.end()) return;
  const auto whole = assembler.add(*chunk);
  if (!whole) return;
  const auto whole_header = open_seal(*whole);
  if (!whole_header || whole_header->run_id != options.run_id) {
    ++counts.damaged;
    return;
  }
  dispatch(*whole_header, whole_channel, *whole);
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

double Bus::arrival_s() const { return state_->arrival_s; }

const BusOptions& Bus::options() const { return state_->options; }

BusCounts Bus::counts() const {
  BusCounts counts = state_->counts;
  counts.messages_out = state_->messages_out.load(std::memory_order_relaxed);
  counts.bytes_out = state_->bytes_out.load(std::memory_order_relaxed);
  counts.send_errors = state_->send_errors.load(std::memory_order_relaxed);
  return counts;
}

int Bus::receive_buffer_bytes() const { return state_->socket.receive_buffer_bytes(); }

std::string Bus::send_error() const {
  const std::lock_guard lock(state_->error_mutex);
  return state_->send_error;
}

const std::array<std::int64_t, kProcesses>& Bus::heard() const { return state_->heard; }

void Bus::count_undecodable() { ++state_->counts.undecodable; }

}  // namespace tandem::wire
