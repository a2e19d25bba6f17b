#include "protocol/wire/multicast_socket.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <linux/filter.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <random>

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

// liblcm says "No route" with a garbage address and goes on; we ask the kernel first.
void require_route(int port) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  const sockaddr_in address = group_address(port);
  const int result = connect(fd, generic(address), sizeof(address));
  const int error = errno;
  close(fd);
  require(result == 0,
          fmt::format("wire: no route to the multicast group {} ({}). On one host: `ip route add "
                      "224.0.0.0/4 dev lo`; between hosts route it to the common network.",
                      kGroup, std::strerror(error)));
}

void set_option(int fd, int level, int option, const void* value, socklen_t size,
                const char* name) {
  if (setsockopt(fd, level, option, value, size) == 0) return;
  throw Error(ErrorKind::Usage, fmt::format("wire: socket option {} on group {}: {}", name, kGroup,
                                            std::strerror(errno)));
}

}  // namespace

MulticastSocket::MulticastSocket(int port, int receive_buffer_bytes) : buffer_(kMaxDatagram) {
  require(port > 0 && port < 65536, fmt::format("wire: port {} is outside 1 … 65535", port));
  require_route(port);
  fd_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  require(fd_ >= 0, fmt::format("wire: cannot open a socket: {}", std::strerror(errno)));
  try {
    open(port, receive_buffer_bytes);
  } catch (...) {
    close(fd_);
    throw;
  }
}

MulticastSocket::~MulticastSocket() { close(fd_); }

void MulticastSocket::open(int port, int receive_buffer_bytes) {
  const int on = 1;
  const int off = 0;
  set_option(fd_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof(on), "SO_REUSEADDR");
  // The kernel clamps this to net.core.rmem_max without a word: read back what was granted.
  set_option(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer_bytes, sizeof(int), "SO_RCVBUF");
  socklen_t size = sizeof(granted_bytes_);
  getsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &granted_bytes_, &size);

  const sockaddr_in address = group_address(port);
  if (bind(fd_, generic(address), sizeof(address)) != 0) {
    throw Error(ErrorKind::Usage,
                fmt::format("wire: cannot listen on {}:{} ({}): another program holds the port. "
                            "Choose another one.",
                            kGroup, port, std::strerror(errno)));
  }
  ip_mreq membership{};
  membership.imr_multiaddr = address.sin_addr;
  membership.imr_interface.s_addr = htonl(INADDR_ANY);
  set_option(fd_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &membership, sizeof(membership),
             "IP_ADD_MEMBERSHIP");
  set_option(fd_, IPPROTO_IP, IP_MULTICAST_ALL, &off, sizeof(off), "IP_MULTICAST_ALL");
}

void MulticastSocket::ignore_sender(std::uint32_t address, std::uint16_t port) {
  constexpr std::uint32_t kWord = BPF_LD | BPF_W | BPF_ABS;
  constexpr std::uint32_t kHalf = BPF_LD | BPF_H | BPF_ABS;
  constexpr std::uint32_t kEqual = BPF_JMP | BPF_JEQ | BPF_K;
  constexpr std::uint32_t kReturn = BPF_RET | BPF_K;
  // The IP source address is at byte 12 of the network header, the UDP source port at byte 0.
  constexpr auto kSourceAddress = static_cast<std::uint32_t>(SKF_NET_OFF) + 12U;
  std::array<sock_filter, 6> steps{{{kWord, 0, 0, kSourceAddress},
                                    {kEqual, 0, 3, address},
                                    {kHalf, 0, 0, 0},
                                    {kEqual, 0, 1, port},
                                    {kReturn, 0, 0, 0},
                                    {kReturn, 0, 0, 0xffffffffU}}};
  const sock_fprog program{static_cast<unsigned short>(steps.size()), steps.data()};
  set_option(fd_, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof(program), "SO_ATTACH_FILTER");
}

bool MulticastSocket::receive(double timeout_s, Datagram& datagram) {
  const double deadline_s = now_s() + timeout_s;
  iovec part{buffer_.data(), buffer_.size()};
  while (true) {
    sockaddr_in from{};
    msghdr message{};
    message.msg_name = &from;
    message.msg_namelen = sizeof(from);
    message.msg_iov = &part;
    message.msg_iovlen = 1;
    const ssize_t size = recvmsg(fd_, &message, MSG_DONTWAIT);
    if (size >= 0) {
      datagram = {};
      datagram.from_address = ntohl(from.sin_addr.s_addr);
      datagram.from_port = ntohs(from.sin_port);
      const ByteView bytes(buffer_.data(), static_cast<std::size_t>(size));
      const bool small_message = bytes.size() > 9 && std::memcmp(bytes.data(), "LC02", 4) == 0;
      if (!small_message) return true;
      const auto end = std::find(bytes.begin() + 8, bytes.end(), std::uint8_t{0});
      if (end == bytes.end()) return true;
      const auto length = static_cast<std::size_t>(end - bytes.begin()) - 8;
      datagram.channel = {reinterpret_cast<const char*>(bytes.data()) + 8, length};
      datagram.payload = bytes.subspan(8 + length + 1);
      return true;
    }
    if (errno == EINTR) continue;
    if (errno != EAGAIN) {
      throw Error(ErrorKind::Partner,
                  fmt::format("wire: receiving on {}: {}", kGroup, std::strerror(errno)));
    }
    const double rest_s = deadline_s - now_s();
    if (rest_s <= 0.0) return false;
    const double whole_s = std::floor(rest_s);
    const timespec timeout{static_cast<time_t>(whole_s),
                           static_cast<long>((rest_s - whole_s) * 1e9)};
    pollfd waiting{fd_, POLLIN, 0};
    if (ppoll(&waiting, 1, &timeout, nullptr) < 0 && errno != EINTR) {
      throw Error(ErrorKind::Partner,
                  fmt::format("wire: waiting on {}: {}", kGroup, std::strerror(errno)));
    }
  }
}

int free_port() {
  std::random_device random;
  for (int attempt = 0; attempt < 200; ++attempt) {
    const int port = 20000 + static_cast<int>(random() % 40000U);
    const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    require(fd >= 0, fmt::format("wire: cannot open a socket: {}", std::strerror(errno)));
    // Without SO_REUSEADDR and on all addresses: fails when anyone at all uses the port.
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_ANY);
    const bool is_free = bind(fd, generic(address), sizeof(address)) == 0;
    close(fd);
    if (is_free) return port;
  }
  throw Error(ErrorKind::Usage, "wire: no free multicast port between 20000 and 59999");
}

}  // namespace tandem::wire
