#include "protocol/wire/loopback_route.h"

#include <arpa/inet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <string>

#include "protocol/wire/receiver.h"

namespace tandem::wire {
namespace {

/// Descriptors of this process's datagram sockets.
std::vector<int> datagram_sockets() {
  std::vector<int> sockets;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd", error)) {
    const int fd = std::stoi(entry.path().filename().string());
    int type = 0;
    socklen_t size = sizeof(type);
    const bool is_socket = getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &size) == 0;
    if (is_socket && type == SOCK_DGRAM) sockets.push_back(fd);
  }
  return sockets;
}

/// Has not been bound, as a socket that only sends; another thread may have opened others
/// meanwhile.
bool only_sends(int fd) {
  sockaddr_in address{};
  socklen_t size = sizeof(address);
  return getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) == 0 &&
         address.sin_family == AF_INET && address.sin_port == 0;
}

}  // namespace

LoopbackRoute::LoopbackRoute() : before_(datagram_sockets()) {}

LoopbackRoute::~LoopbackRoute() {
  if (membership_ >= 0) close(membership_);
}

void LoopbackRoute::apply() {
  const std::vector<int> now = datagram_sockets();
  ip_mreqn loopback{};
  inet_pton(AF_INET, kGroup, &loopback.imr_multiaddr);
  loopback.imr_ifindex = static_cast<int>(if_nametoindex("lo"));
  membership_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (loopback.imr_ifindex == 0 || membership_ < 0 ||
      setsockopt(membership_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &loopback, sizeof(loopback)) != 0) {
    return;
  }
  for (const int fd : now) {
    if (std::find(before_.begin(), before_.end(), fd) != before_.end() || !only_sends(fd)) continue;
    setsockopt(fd, IPPROTO_IP, IP_MULTICAST_IF, &loopback, sizeof(loopback));
  }
}

}  // namespace tandem::wire
