#include "protocol/wire/request_server.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"

namespace tandem::wire {
namespace {

constexpr double kIdle_s = 0.1;
// A long step lets repetitions of its request pile up in the socket. Its reply has just been sent;
// those that are older than the client's shortest time-out need no other one.
constexpr double kRepeatPause_s = 0.01;

}  // namespace

RequestServer::RequestServer(Bus& bus, LivenessMonitor& monitor, ServerOptions options,
                             const SubsystemInfo& info, Execute execute)
    : bus_(bus),
      monitor_(monitor),
      options_(std::move(options)),
      info_(info),
      execute_(std::move(execute)) {}

void RequestServer::run() {
  const Process self = bus_.options().self;
  const HelloServer hello(bus_, info_, options_.scenario_hash, options_.tandem_version);
  const Subscription request = bus_.subscribe(
      self, Kind::Request,
      [this](const Header& header, ByteView message) { on_request(header, message); });
  // To one of several bodies the driver may speak together with the others.
  Subscription requests;
  if (static_cast<std::size_t>(self) >= kFirstBody) {
    requests = bus_.subscribe(Process::Fem, Kind::Requests,
                              [this](const Header&, ByteView message) { on_requests(message); });
  }
  const Subscription closed =
      bus_.subscribe(self, Kind::Closed, [this](const Header&, ByteView) { closed_ = done_; });
  if (options_.heartbeat != nullptr) options_.heartbeat->set_phase("waiting for the driver");
  while (!done_ && !failure_) {
    monitor_.wait(kIdle_s);
    look_at(hello);
  }
  // The last answer may have been lost: stay for repetitions until the client confirms it.
  const double end_s = now_s() + options_.linger_s;
  while (!closed_ && now_s() < end_s) {
    try {
      monitor_.wait(std::min(kIdle_s, std::max(0.0, end_s - now_s())));
    } catch (const Error&) {
      break;  // the client has ended: nobody is left who could ask again
    }
  }
  if (failure_) std::rethrow_exception(failure_);
}

void RequestServer::look_at(const HelloServer& hello) {
  if (hello.greeted() && options_.heartbeat != nullptr && !std::exchange(greeted_, true)) {
    options_.heartbeat->set_phase("answering the driver");
  }
  // Stays and refuses again for as long as it lingers: the refusal may be lost.
  if (!hello.refusal().empty() && !failure_) {
    failure_ = std::make_exception_ptr(
        Error(ErrorKind::Usage, fmt::format("{}: the driver does not fit: {}",
                                            bus_.name_of(bus_.options().self), hello.refusal())));
  }
}

void RequestServer::on_request(const Header& header, ByteView message) {
  if (header.sequence == last_ + 1 && !done_ && !failure_) {
    execute(message);
    return;
  }
  if (header.sequence <= last_) ++duplicates_;
  if (header.sequence == last_) repeat_reply();
  if (header.sequence > last_ + 1 && !failure_) {
    failure_ = std::make_exception_ptr(
        Error(ErrorKind::Partner,
              fmt::format(
                  "{}: request {} (macro step {}) arrived after request {}: the ones between were "
                  "never sent. Is a second driver on this run?",
                  bus_.name_of(bus_.options().self), header.sequence, header.macro_step, last_)));
  }
}

void RequestServer::on_requests(ByteView message) {
  const std::optional<ByteView> own = request_to(bus_.options().self, message);
  if (!own) return bus_.count_undecodable();
  if (!own->empty()) on_request(header_of(*own), *own);
}

void RequestServer::execute(ByteView message) {
  const double begin_s = bus_.arrival_s();
  if (!decode(message, request_)) {
    bus_.count_undecodable();
    return;
  }
  const Header& header = request_.header;
  Reply reply;
  reply.header = bus_.header(Kind::Reply, header.sequence);
  reply.header.macro_step = header.macro_step;
  reply.header.iteration = header.iteration;
  monitor_.set_macro_step(header.macro_step);
  if (options_.heartbeat != nullptr) options_.heartbeat->set_macro_step(header.macro_step);
  const double compute_s = now_s();
  reply.cost.decode_s = compute_s - begin_s;
  try {
    execute_(request_, reply);
  } catch (const Error& error) {
    reply.error = error.kind();
    reply.message = error.what();
    failure_ = std::current_exception();
  } catch (const std::exception& error) {
    reply.error = ErrorKind::Partner;
    reply.message = error.what();
    failure_ = std::current_exception();
  }
  reply.cost.compute_s = now_s() - compute_s;
  reply.header.time_us = wall_clock_us();
  last_ = header.sequence;
  publish_reply(reply);
  done_ = request_.call == RequestKind::Bye;
}

void RequestServer::publish_reply(Reply& reply) {
  reply.cost.publish_s = publish_cost_s_;
  reply.duplicates = duplicates_;
  const double begin_s = now_s();
  encode(reply, reply_);
  const double publish_s = now_s();
  patch_double(reply_, kReplyEncodeAt, publish_s - begin_s);
  repeats_ = 0;
  bus_.publish(bus_.options().self, Kind::Reply, reply_, 0);
  reply_s_ = now_s();
  publish_cost_s_ = reply_s_ - publish_s;
}

void RequestServer::repeat_reply() {
  if (now_s() - reply_s_ < kRepeatPause_s) return;
  bus_.publish(bus_.options().self, Kind::Reply, reply_, ++repeats_);
  reply_s_ = now_s();
}

}  // namespace tandem::wire
