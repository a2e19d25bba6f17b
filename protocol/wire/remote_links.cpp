#include "protocol/wire/remote_links.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "protocol/contract/cost.h"
#include "protocol/wire/chunks_sent.h"

namespace tandem::wire {

RemoteLinks::RemoteLinks(Bus& bus, LivenessMonitor& monitor) : bus_(bus), monitor_(monitor) {
  monitor_.tell_of_bodies([this](Process side) { return state_of(side); });
}

RemoteLinks::~RemoteLinks() { monitor_.tell_of_bodies({}); }

void RemoteLinks::add(RemoteLink& link) {
  links_.push_back(&link);
  link.links_ = this;
}

void RemoteLinks::begun(RemoteLink& link) {
  begun_.push_back(&link);
  if (begun_.size() == links_.size()) send();
}

// Each side takes in the requests of all. That costs it less than the system calls that are saved,
// as long as they fit one datagram.
bool RemoteLinks::fits_one() const {
  constexpr std::size_t kOwnHead = 64 + 8;  // more than that of the message, at least that of each
  std::size_t bytes = kOwnHead;
  for (const RemoteLink* link : begun_) bytes += kOwnHead + link->request_.size();
  return bytes <= kMaxWhole;
}

void RemoteLinks::send() {
  if (begun_.size() > 1 && fits_one()) {
    send_together();
  } else {
    for (RemoteLink* link : begun_) link->send_first();
  }
  begun_.clear();
}

void RemoteLinks::send_together() {
  const double encode_s = now_s();
  const RemoteLink& first = *begun_.front();
  Header header = bus_.header(Kind::Requests, ++sequence_);
  header.macro_step = first.macro_step_;
  header.iteration = first.iteration_;
  begin_requests(message_);
  for (const RemoteLink* link : begun_) append(link->options_.side, link->request_, message_);
  end_requests(header, message_);
  const double begin_s = now_s();
  for (RemoteLink* link : begun_) link->leaves(begin_s);
  const Sent sent = bus_.publish(Process::Fem, Kind::Requests, message_);
  CallCost& cost = begun_.front()->open_cost_;
  cost.encode_s += begin_s - encode_s;
  cost.publish_s += now_s() - begin_s;
  cost.messages += sent.messages;
  cost.bytes += sent.bytes;
}

void RemoteLinks::await(const RemoteLink& link) {
  for (RemoteLink* any : links_) any->watch();
  while (link.is_open()) {
    double resend_s = std::numeric_limits<double>::infinity();
    for (const RemoteLink* any : links_) {
      if (any->is_open()) resend_s = std::min(resend_s, any->resend_s_);
    }
    monitor_.wait(std::max(0.0, resend_s - now_s()));
    for (RemoteLink* any : links_) any->repeat_if_late();
  }
}

std::string RemoteLinks::state_of(Process side) const {
  const auto found = std::find_if(links_.begin(), links_.end(), [&](const RemoteLink* link) {
    return link->options_.side == side;
  });
  if (found == links_.end()) return {};
  const RemoteLink& link = **found;
  if (!link.is_open()) return "has answered";
  return fmt::format("was asked {:.2g} s ago, macro step {}, iteration {}, and has not answered",
                     now_s() - link.begin_s_, link.macro_step_, link.iteration_);
}

}  // namespace tandem::wire
