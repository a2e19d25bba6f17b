#include "orchestrator/bench/ping_pong.h"

#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <thread>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"

namespace tandem::orchestrator {
namespace {

constexpr std::size_t kDatagram = 59000;

[[noreturn]] void fail(const char* what) {
  throw Error(ErrorKind::System, fmt::format("bench: {}: {}. The loopback interface must be up "
                                             "(`ip link set lo up`).",
                                             what, std::strerror(errno)));
}

sockaddr_in loopback(int port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  return address;
}

FileDescriptor open_socket(int type) {
  FileDescriptor opened(socket(AF_INET, type | SOCK_CLOEXEC, 0));
  const int fd = opened.get();
  if (fd < 0) fail("cannot open a socket");
  const int on = 1;
  const int buffer_bytes = 4194304;
  if (type == SOCK_STREAM) {
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
  } else {
    setsockopt(fd, SOL_SOCKET, SO_RCVBUF, &buffer_bytes, sizeof(buffer_bytes));
  }
  return opened;
}

FileDescriptor bound_socket(int type) {
  FileDescriptor opened = open_socket(type);
  const sockaddr_in address = loopback(0);
  if (bind(opened.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    fail("cannot bind to 127.0.0.1");
  }
  return opened;
}

FileDescriptor connected_socket(int type, int port) {
  FileDescriptor opened = open_socket(type);
  const sockaddr_in address = loopback(port);
  if (connect(opened.get(), reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0) {
    fail("cannot connect to 127.0.0.1");
  }
  return opened;
}

int port_of(int fd) {
  sockaddr_in address{};
  socklen_t size = sizeof(address);
  getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.sin_port);
}

bool write_all(int fd, const char* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t done = write(fd, bytes, size);
    if (done <= 0) return false;
    bytes += done;
    size -= static_cast<std::size_t>(done);
  }
  return true;
}

bool read_all(int fd, char* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t done = read(fd, bytes, size);
    if (done <= 0) return false;
    bytes += done;
    size -= static_cast<std::size_t>(done);
  }
  return true;
}

/// In datagrams that each begin with the number of the ping.
void send_datagrams(int fd, std::uint32_t number, std::vector<char>& payload,
                    const sockaddr_in* to) {
  for (std::size_t begin = 0; begin < payload.size(); begin += kDatagram) {
    const std::size_t size = std::min(kDatagram, payload.size() - begin);
    std::memcpy(payload.data() + begin, &number, sizeof(number));
    sendto(fd, payload.data() + begin, size, 0, reinterpret_cast<const sockaddr*>(to),
           to == nullptr ? 0 : sizeof(*to));
  }
}

/// All `wanted` bytes of the ping that `number` names on return; parts of earlier ones are passed
/// over. `payload` has room for one datagram more.
bool receive_datagrams(int fd, std::uint32_t& number, bool follow, std::size_t wanted,
                       std::vector<char>& payload, sockaddr_in* from) {
  std::size_t here = 0;
  while (here < wanted) {
    socklen_t address_size = sizeof(sockaddr_in);
    const ssize_t size =
        recvfrom(fd, payload.data() + here, payload.size() - here, 0,
                 reinterpret_cast<sockaddr*>(from), from == nullptr ? nullptr : &address_size);
    if (size < static_cast<ssize_t>(sizeof(number))) return false;
    std::uint32_t of = 0;
    std::memcpy(&of, payload.data() + here, sizeof(of));
    if (of != number) {
      if (!follow) continue;
      number = of;
      std::memmove(payload.data(), payload.data() + here, static_cast<std::size_t>(size));
      here = 0;
    }
    here += static_cast<std::size_t>(size);
  }
  return true;
}

void answer_tcp(int listener, PingPongSizes sizes) {
  const FileDescriptor accepted(accept4(listener, nullptr, nullptr, SOCK_CLOEXEC));
  const int fd = accepted.get();
  const int on = 1;
  setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
  std::vector<char> in(sizes.there);
  const std::vector<char> out(sizes.back);
  while (read_all(fd, in.data(), in.size()) && write_all(fd, out.data(), out.size())) {
  }
}

void answer_udp(int fd, PingPongSizes sizes) {
  std::vector<char> in(sizes.there + kDatagram);
  std::vector<char> out(sizes.back);
  std::uint32_t number = 0;
  sockaddr_in from{};
  while (receive_datagrams(fd, number, true, sizes.there, in, &from))
    send_datagrams(fd, number, out, &from);
}

}  // namespace

PingPongSockets::PingPongSockets()
    : tcp_(bound_socket(SOCK_STREAM)), udp_(bound_socket(SOCK_DGRAM)) {
  if (listen(tcp_.get(), 1) != 0) fail("cannot listen on 127.0.0.1");
}

int PingPongSockets::tcp_port() const { return port_of(tcp_.get()); }
int PingPongSockets::udp_port() const { return port_of(udp_.get()); }

void answer_pings(const PingPongSockets& sockets, PingPongSizes sizes) {
  std::thread([fd = sockets.tcp_listener(), sizes] { answer_tcp(fd, sizes); }).detach();
  std::thread([fd = sockets.udp(), sizes] { answer_udp(fd, sizes); }).detach();
}

PingPong::PingPong(const PingPongSockets& sockets, PingPongSizes sizes)
    : sizes_(sizes),
      tcp_(connected_socket(SOCK_STREAM, sockets.tcp_port())),
      udp_(connected_socket(SOCK_DGRAM, sockets.udp_port())),
      out_(sizes.there),
      in_(sizes.back + kDatagram) {
  const timeval patience{1, 0};
  setsockopt(udp_.get(), SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof(patience));
}

std::vector<double> PingPong::tcp_us(int count) {
  std::vector<double> times_us;
  for (int i = 0; i < count; ++i) {
    const double begin_s = now_s();
    if (!write_all(tcp_.get(), out_.data(), out_.size()) ||
        !read_all(tcp_.get(), in_.data(), sizes_.back)) {
      fail("TCP over 127.0.0.1");
    }
    times_us.push_back(1e6 * (now_s() - begin_s));
  }
  return times_us;
}

std::vector<double> PingPong::udp_us(int count) {
  constexpr int kMaxLost = 10;
  std::vector<double> times_us;
  for (int lost = 0; static_cast<int>(times_us.size()) < count && lost < kMaxLost;) {
    ++number_;
    const double begin_s = now_s();
    send_datagrams(udp_.get(), number_, out_, nullptr);
    if (receive_datagrams(udp_.get(), number_, false, sizes_.back, in_, nullptr)) {
      times_us.push_back(1e6 * (now_s() - begin_s));
    } else {
      ++lost;
    }
  }
  if (static_cast<int>(times_us.size()) < count) fail("UDP over 127.0.0.1 loses its datagrams");
  return times_us;
}

}  // namespace tandem::orchestrator
