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

/// Port that an IPv4 socket is bound to: 0 = none, as of a socket that only sends; −1 = another
/// kind of socket (another thread may have opened one meanwhile).
int bound_port(int fd) {
  sockaddr_in address{};
  socklen_t size = sizeof(address);
  const bool known = getsockname(fd, reinterpret_cast<sockaddr*>(&address), &size) == 0;
  return known && address.sin_family == AF_INET ? ntohs(address.sin_port) : -1;
}

/// The group on the loopback interface; index 0 where there is none.
ip_mreqn on_loopback() {
  ip_mreqn group{};
  inet_pton(AF_INET, kGroup, &group.imr_multiaddr);
  group.imr_ifindex = static_cast<int>(if_nametoindex("lo"));
  return group;
}

/// liblcm joins the group on the interface that its route leads to, also with sockets that only
/// send.
void leave_route(int fd) {
  ip_mreqn routed = on_loopback();
  routed.imr_ifindex = 0;
  setsockopt(fd, IPPROTO_IP, IP_DROP_MEMBERSHIP, &routed, sizeof(routed));
}

}  // namespace

LoopbackRoute::LoopbackRoute() : before_(datagram_sockets()) {}

LoopbackRoute::~LoopbackRoute() {
  if (membership_ >= 0) close(membership_);
}

void LoopbackRoute::apply() {
  const std::vector<int> now = datagram_sockets();
  const ip_mreqn loopback = on_loopback();
  membership_ = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (loopback.imr_ifindex == 0 || membership_ < 0 ||
      setsockopt(membership_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &loopback, sizeof(loopback)) != 0) {
    return;
  }
  for (const int fd : now) {
    if (std::find(before_.begin(), before_.end(), fd) != before_.end()) continue;
    if (bound_port(fd) != 0) continue;
    setsockopt(fd, IPPROTO_IP, IP_MULTICAST_IF, &loopback, sizeof(loopback));
    leave_route(fd);
  }
}

void LoopbackRoute::listen(int port) {
  const ip_mreqn loopback = on_loopback();
  if (loopback.imr_ifindex == 0) return;
  for (const int fd : datagram_sockets()) {
    if (std::find(before_.begin(), before_.end(), fd) != before_.end()) continue;
    const int bound = bound_port(fd);
    if (bound < 0) continue;
    const int off = 0;
    // The route may lead to the loopback interface itself: then there is nothing to leave.
    const bool stays = bound == port && setsockopt(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, &loopback,
                                                   sizeof(loopback)) != 0;
    if (!stays) leave_route(fd);
    if (bound == port) setsockopt(fd, IPPROTO_IP, IP_MULTICAST_ALL, &off, sizeof(off));
  }
}

}  // namespace tandem::wire
