#include "protocol/wire/lcm_receiver.h"

#include <fmt/format.h>
#include <lcm/lcm.h>
#include <poll.h>
#include <sys/select.h>

#include <cerrno>
#include <cmath>
#include <utility>

#include "protocol/contract/error.h"
#include "protocol/wire/multicast_socket.h"

namespace tandem::wire {

struct LcmReceiver::Lcm {
  explicit Lcm(const std::string& url) : handle(lcm_create(url.c_str())) {}
  ~Lcm() {
    if (handle != nullptr) lcm_destroy(handle);
  }
  Lcm(const Lcm&) = delete;
  Lcm& operator=(const Lcm&) = delete;
  lcm_t* handle;
  int fd = -1;
};

LcmReceiver::LcmReceiver(const ReceiverOptions& options) {
  require_multicast_route(options.port);
  lcm_ =
      std::make_unique<Lcm>(fmt::format("udpm://{}:{}?ttl={}&recv_buf_size={}", kGroup,
                                        options.port, options.ttl, options.receive_buffer_bytes));
  require(lcm_->handle != nullptr, fmt::format("wire: liblcm cannot open {}", kGroup));
  const auto keep = [](const lcm_recv_buf_t* buffer, const char* channel, void* user) {
    const auto* bytes = static_cast<const std::uint8_t*>(buffer->data);
    auto* self = static_cast<LcmReceiver*>(user);
    // No exception may pass through liblcm's frames, which are C.
    try {
      self->arrived_.push_back({channel, Bytes(bytes, bytes + buffer->data_size)});
    } catch (...) {
      self->failure_ = std::current_exception();
    }
  };
  // A second subscribe after a failed one would give a deaf subscription: the first one decides.
  lcm_subscription_t* subscription = lcm_subscribe(lcm_->handle, ".*", keep, this);
  require(subscription != nullptr,
          fmt::format("wire: liblcm cannot listen on udp {}:{}: a firewall filters multicast or "
                      "another program holds the port. `wire.receive: own` says which.",
                      kGroup, options.port));
  if (options.ttl == 0) loopback_.listen(options.port);
  lcm_subscription_set_queue_capacity(subscription, 0);  // the default drops beyond 30 messages
  lcm_->fd = lcm_get_fileno(lcm_->handle);
  require(lcm_->fd >= 0 && lcm_->fd < FD_SETSIZE,
          "wire: liblcm cannot work with so many open files; use `wire.receive: own`");
}

LcmReceiver::~LcmReceiver() = default;

bool LcmReceiver::receive(double timeout_s, Datagram& datagram) {
  while (arrived_.empty()) {
    pollfd waiting{lcm_->fd, POLLIN, 0};
    const double whole_s = std::floor(timeout_s);
    const timespec timeout{static_cast<time_t>(whole_s),
                           static_cast<long>((timeout_s - whole_s) * 1e9)};
    const int ready = ppoll(&waiting, 1, &timeout, nullptr);
    if (ready < 0 && errno == EINTR) continue;
    if (ready <= 0) return false;
    const int handled = lcm_handle(lcm_->handle);
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    if (handled != 0 && errno != EINTR) {
      throw Error(ErrorKind::Partner, fmt::format("wire: liblcm cannot receive on {}", kGroup));
    }
  }
  handed_out_ = std::move(arrived_.front());
  arrived_.pop_front();
  datagram = {.channel = handed_out_.channel, .payload = handed_out_.payload};
  return true;
}

}  // namespace tandem::wire
