#include "protocol/wire/multicast_socket.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sched.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <vector>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"

namespace tandem::wire {
namespace {

constexpr std::size_t kMaxDatagram = 65536;

sockaddr_in group_address(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  inet_pton(AF_INET, kGroup, &address.sin_addr);
  return address;
}

const sockaddr* generic(const sockaddr_in& address) {
  return reinterpret_cast<const sockaddr*>(&address);
}

void set_option(int fd, int level, int option, const void* value, socklen_t size,
                const char* name) {
  if (setsockopt(fd, level, option, value, size) == 0) return;
  throw Error(ErrorKind::Usage, fmt::format("wire: socket option {} on group {}: {}", name, kGroup,
                                            std::strerror(errno)));
}

}  // namespace

MulticastSocket::MulticastSocket(const ReceiverOptions& options)
    : budget_(options.wait), buffer_(kMaxDatagram) {
  require(options.port > 0 && options.port < 65536,
          fmt::format("wire: port {} is outside 1 … 65535", options.port));
  require_multicast_route(options.port);
  fd_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  require(fd_ >= 0, fmt::format("wire: cannot open a socket: {}", std::strerror(errno)));
  try {
    open(options);
  } catch (...) {
    close(fd_);
    throw;
  }
}

MulticastSocket::~MulticastSocket() { close(fd_); }

void MulticastSocket::open(const ReceiverOptions& options) {
  const int on = 1;
  const int off = 0;
  set_option(fd_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on), "SO_REUSEADDR");
  // The kernel clamps this to net.core.rmem_max without a word: read back what was granted.
  set_option(fd_, SOL_SOCKET, SO_RCVBUF, &options.receive_buffer_bytes, sizeof(int), "SO_RCVBUF");
  socklen_t size = sizeof(granted_bytes_);
  getsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &granted_bytes_, &size);

  const sockaddr_in address = group_address(options.port);
  if (bind(fd_, generic(address), sizeof(address)) != 0) {
    throw Error(ErrorKind::Usage,
                fmt::format("wire: cannot listen on {}:{} ({}): another program holds the port. "
                            "Choose another one.",
                            kGroup, options.port, std::strerror(errno)));
  }
  join(options.ttl);
  set_option(fd_, IPPROTO_IP, IP_MULTICAST_ALL, &off, sizeof(off), "IP_MULTICAST_ALL");
}

// Partners on this host send through the loopback interface wherever the route leads. A run that
// stays on the host hears nothing else; where there is no such interface, the route's serves.
void MulticastSocket::join(int ttl) {
  ip_mreqn membership{};
  membership.imr_multiaddr = group_address(0).sin_addr;
  membership.imr_ifindex = static_cast<int>(if_nametoindex("lo"));
  const bool local = membership.imr_ifindex > 0 && setsockopt(fd_, IPPROTO_IP, IP_ADD_MEMBERSHIP,
                                                              &membership, sizeof(membership)) == 0;
  if (local && ttl == 0) return;
  membership.imr_ifindex = 0;
  const bool routed =
      setsockopt(fd_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership)) == 0;
  // The route may lead to the loopback interface itself.
  if (routed || (local && errno == EADDRINUSE)) return;
  throw Error(ErrorKind::Usage,
              fmt::format("wire: cannot join group {}: {}", kGroup, std::strerror(errno)));
}

void MulticastSocket::attach(const ChannelFilter& filter) {
  std::vector<sock_filter> steps = compile(filter);
  const sock_fprog program{static_cast<unsigned short>(steps.size()), steps.data()};
  set_option(fd_, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof(program), "SO_ATTACH_FILTER");
}

// One blocking call receives; setting another time-out would be a second one. So times are rounded
// up to a power of two of 1 ms, and most calls find the socket as they need it.
void MulticastSocket::set_timeout(double timeout_s) {
  const double rounded_s =
      0.001 * std::exp2(std::ceil(std::log2(std::max(timeout_s, 1e-3) / 1e-3)));
  if (rounded_s == timeout_s_) return;
  const double whole_s = std::floor(rounded_s);
  const timeval timeout{static_cast<time_t>(whole_s),
                        static_cast<suseconds_t>((rounded_s - whole_s) * 1e6)};
  set_option(fd_, SOL_SOCKET, SO_RCVTIMEO, &timeout, sizeof(timeout), "SO_RCVTIMEO");
  timeout_s_ = rounded_s;
}

std::ptrdiff_t MulticastSocket::take(int flags, sockaddr_in& from) {
  socklen_t from_size = sizeof(from);
  ssize_t size = -1;
  do {
    size = recvfrom(fd_, buffer_.data(), buffer_.size(), flags, reinterpret_cast<sockaddr*>(&from),
                    &from_size);
  } while (size < 0 && errno == EINTR);
  if (size >= 0 || errno == EAGAIN || errno == EWOULDBLOCK) return size;
  throw Error(ErrorKind::Partner,
              fmt::format("wire: receiving on {}: {}", kGroup, std::strerror(errno)));
}

std::ptrdiff_t MulticastSocket::poll(double begin_s, double budget_s, sockaddr_in& from) {
  double looked_s = begin_s;
  while (true) {
    const std::ptrdiff_t size = take(MSG_DONTWAIT, from);
    if (size >= 0) return size;
    const double time_s = now_s();
    if (time_s - looked_s > PollBudget::kPreempted_s) {
      budget_.preempted();
      return -1;
    }
    if (time_s - begin_s >= budget_s) return -1;
    looked_s = time_s;
    // The kernel may have put the sender on this core: it goes first.
    sched_yield();
  }
}

std::ptrdiff_t MulticastSocket::wait(double timeout_s, sockaddr_in& from) {
  const double begin_s = now_s();
  const double budget_s = std::min(timeout_s, budget_.begin());
  std::ptrdiff_t size = budget_s > 0.0 ? poll(begin_s, budget_s, from) : -1;
  if (size < 0) {
    set_timeout(timeout_s);
    size = take(0, from);
  }
  if (size >= 0) budget_.end(now_s() - begin_s);
  return size;
}

bool MulticastSocket::receive(double timeout_s, Datagram& datagram) {
  sockaddr_in from{};
  const std::ptrdiff_t size = timeout_s > 0.0 ? wait(timeout_s, from) : take(MSG_DONTWAIT, from);
  if (size < 0) return false;
  datagram = {};
  datagram.from_address = ntohl(from.sin_addr.s_addr);
  datagram.from_port = ntohs(from.sin_port);
  const ByteView bytes(buffer_.data(), static_cast<std::size_t>(size));
  const bool small_message = bytes.size() > 9 && std::memcmp(bytes.data(), "LC02", 4) == 0;
  if (!small_message) return true;
  const auto* end =
      static_cast<const std::uint8_t*>(std::memchr(bytes.data() + 8, 0, bytes.size() - 8));
  if (end == nullptr) return true;
  const auto length = static_cast<std::size_t>(end - bytes.data()) - 8;
  datagram.channel = {reinterpret_cast<const char*>(bytes.data()) + 8, length};
  datagram.payload = bytes.subspan(8 + length + 1);
  return true;
}

}  // namespace tandem::wire
