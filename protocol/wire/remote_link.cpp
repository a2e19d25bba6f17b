#include "protocol/wire/remote_link.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <utility>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"
#include "protocol/wire/remote_links.h"
#include "protocol/wire/resend_timeouts.h"

namespace tandem::wire {
namespace {

constexpr double kByeTime_s = 2.0;

}  // namespace

RemoteLink::RemoteLink(Bus& bus, LivenessMonitor& monitor, RemoteOptions options)
    : bus_(bus), monitor_(monitor), options_(std::move(options)) {
  replies_ =
      bus_.subscribe(options_.side, Kind::Reply,
                     [this](const Header& header, ByteView message) { on_reply(header, message); });
}

Handshake RemoteLink::connect() {
  // The side may load a large model for as long as it says that it lives.
  return greet(bus_, monitor_, options_, std::numeric_limits<double>::infinity());
}

void RemoteLink::send(Bytes& message, std::int32_t attempt, CallCost& cost) {
  const double begin_s = now_s();
  const Sent sent = bus_.publish(options_.side, Kind::Request, message, attempt);
  cost.publish_s += now_s() - begin_s;
  cost.messages += sent.messages;
  cost.bytes += sent.bytes;
}

void RemoteLink::on_reply(const Header& header, ByteView message) {
  if (header.sequence != sequence_ || reply_bytes_ > 0) {
    ++stale_;
    return;
  }
  arrival_s_ = bus_.arrival_s();
  reply_bytes_ = message.size();
  other_schema_ = !decode(message, reply_);
  decode_s_ = now_s() - arrival_s_;
}

void RemoteLink::send_first() {
  leaves(now_s());
  send(request_, 0, open_cost_);
}

void RemoteLink::leaves(double time_s) {
  begin_s_ = time_s;
  sent_ = true;
  watched_ = false;
}

void RemoteLink::watch() {
  if (!is_open() || std::exchange(watched_, true)) return;
  timeout_s_ = kFirstTimeout_s;
  resend_s_ = now_s() + timeout_s_;
}

void RemoteLink::repeat_if_late() {
  if (!is_open() || now_s() < resend_s_) return;
  send(request_, static_cast<std::int32_t>(++open_cost_.resent), open_cost_);
  timeout_s_ = std::min(2.0 * timeout_s_, kLastTimeout_s);
  resend_s_ = now_s() + timeout_s_;
}

void RemoteLink::await_reply() {
  if (links_ != nullptr) return links_->await(*this);
  watch();
  while (is_open()) {
    monitor_.wait(std::max(0.0, resend_s_ - now_s()));
    repeat_if_late();
  }
}

void RemoteLink::book(double blocked_s) {
  // What neither process books is on the way: kernel, wake-up, waiting for a lost message. On one
  // core we may wake while the server still is in its publish call: only the part of it that fits
  // into the round trip delayed us.
  CallCost& cost = open_cost_;
  const double round_trip_s = arrival_s_ - begin_s_;
  const ServerCost& server = reply_.cost;
  const double server_s = server.compute_s + server.decode_s + server.encode_s;
  // On one core the woken server runs inside our own publish call: what it books is not ours.
  cost.publish_s = std::min(cost.publish_s, std::max(0.0, round_trip_s - server_s));
  const double rest_s = std::max(0.0, round_trip_s - cost.publish_s - server_s);
  const double server_publish_s = std::clamp(server.publish_s, 0.0, rest_s);
  // A reply that lay here while the caller did other work was not on the way for so long.
  cost.transit_s = std::min(rest_s - server_publish_s, blocked_s);
  cost.compute_s = server.compute_s;
  cost.encode_s += server.encode_s;
  cost.decode_s += server.decode_s;
  cost.publish_s += server_publish_s;
  cost.messages += 1;
  cost.bytes += static_cast<std::int64_t>(reply_bytes_);
  cost.duplicates = std::exchange(stale_, 0) + reply_.duplicates -
                    std::exchange(server_duplicates_, reply_.duplicates);
}

Reply& RemoteLink::call(const RequestView& request, CallCost& cost) {
  begin(request);
  return finish(cost);
}

void RemoteLink::begin(const RequestView& request) {
  open_cost_ = {};
  call_ = request.head.call;
  Header& header = request.head.header;
  const Header given = std::exchange(header, bus_.header(Kind::Request, ++sequence_));
  header.macro_step = macro_step_ = given.macro_step;
  header.iteration = iteration_ = given.iteration;
  const double encode_s = now_s();
  encode(request, request_);
  given_bytes_ =
      request.motions_end.size() * kMotionBytes + request.wrenches_end.size() * kWrenchBytes;
  if (request.head.call == RequestKind::Initialize || request.head.call == RequestKind::Advance) {
    given_ = Given::Here;
  } else if (given_ == Given::Here) {
    given_ = Given::Lost;
  }
  open_cost_.encode_s = now_s() - encode_s;
  monitor_.set_macro_step(macro_step_);
  reply_bytes_ = 0;
  if (links_ != nullptr) return links_->begun(*this);
  send_first();
}

Reply& RemoteLink::finish(CallCost& cost) {
  if (links_ != nullptr) links_->send();
  finish_s_ = now_s();
  await_reply();
  sent_ = false;
  if (other_schema_) {
    throw Error(ErrorKind::Partner,
                fmt::format("{}: reply {} (macro step {}) cannot be decoded: {} speaks another "
                            "message schema. Install both from one build.",
                            bus_.name_of(options_.side), sequence_, macro_step_,
                            bus_.program_of(options_.side)));
  }
  open_cost_.decode_s = decode_s_;
  book(std::max(0.0, arrival_s_ - finish_s_));
  cost += open_cost_;
  total_ += open_cost_;
  if (reply_.error) {
    const std::string name = std::string(bus_.name_of(options_.side)) + ": ";
    const bool named = reply_.message.starts_with(name);
    throw Error(*reply_.error, (named ? "" : name) + reply_.message);
  }
  check_reply();
  return reply_;
}

PartTimes RemoteLink::times() const {
  return {.sent_s = begin_s_,
          .awaited_s = finish_s_,
          .arrived_s = arrival_s_,
          .side_us = static_cast<double>(reply_.header.time_us),
          .compute_s = reply_.cost.compute_s,
          .decode_s = reply_.cost.decode_s,
          .encode_s = reply_.cost.encode_s};
}

// A good checksum says that the message is what its sender wrote, not that it is the answer.
void RemoteLink::check_reply() const {
  const auto refuse = [this](const std::string& what) {
    throw Error(ErrorKind::Partner,
                fmt::format("{}: reply {} of {} (macro step {}, iteration {}) {}. Is a second "
                            "driver on this run?",
                            bus_.name_of(options_.side), sequence_, bus_.program_of(options_.side),
                            macro_step_, iteration_, what));
  };
  if (reply_.header.macro_step != macro_step_ || reply_.header.iteration != iteration_) {
    refuse(fmt::format("answers another request, of macro step {}, iteration {}",
                       reply_.header.macro_step, reply_.header.iteration));
  }
  const std::size_t ports = options_.port_names.size();
  const bool gives = call_ == RequestKind::Initialize || call_ == RequestKind::Advance;
  const bool from_mbs = is_multibody(options_.side);
  const std::size_t motions = reply_.motions.size();
  const std::size_t wrenches = reply_.wrenches.size();
  const std::size_t output = from_mbs ? motions : wrenches;
  // A side that failed may not have got as far as its output.
  const bool fits =
      output == (gives ? ports : 0) || (output == 0 && reply_.outcome == Outcome::Failed);
  if (!fits || motions + wrenches != output) {
    refuse(fmt::format("holds {} motions and {} wrenches; the run has {} ports", motions, wrenches,
                       ports));
  }
  if (!reply_.jacobian) return;
  const auto wrench_size = static_cast<Eigen::Index>(6 * ports);
  const Eigen::Index rows = from_mbs ? 2 * wrench_size : wrench_size;
  const Eigen::Index columns = from_mbs ? wrench_size : 2 * wrench_size;
  if (reply_.jacobian->rows() != rows || reply_.jacobian->cols() != columns) {
    refuse(fmt::format("holds a Jacobian of {} × {} in place of {} × {}", reply_.jacobian->rows(),
                       reply_.jacobian->cols(), rows, columns));
  }
}

void RemoteLink::accept_input() {
  if (given_ == Given::Here) std::swap(request_, accepted_);
  if (given_ != Given::Nothing) accepted_bytes_ = given_ == Given::Here ? given_bytes_ : 0;
  given_ = Given::Nothing;
}

void RemoteLink::bye() {
  Request request;
  request.call = RequestKind::Bye;
  request.header = bus_.header(Kind::Request, ++sequence_);
  Bytes message = encode(request);
  reply_bytes_ = 0;
  const double end_s = now_s() + kByeTime_s;
  double timeout_s = kFirstTimeout_s;
  // A side that is gone already has had its bye: not worth an error.
  for (std::int32_t attempt = 0; reply_bytes_ == 0 && now_s() < end_s; ++attempt) {
    send(message, attempt, total_);
    const double resend_s = now_s() + timeout_s;
    while (reply_bytes_ == 0 && now_s() < resend_s)
      monitor_.wait(std::max(0.0, resend_s - now_s()));
    timeout_s = std::min(2.0 * timeout_s, kLastTimeout_s);
  }
  for (std::int32_t attempt = 0; attempt < 3; ++attempt) {
    Bytes closed = encode(Credit{bus_.header(Kind::Closed, sequence_), 0, 0});
    bus_.publish(options_.side, Kind::Closed, closed, attempt);
  }
}

}  // namespace tandem::wire
