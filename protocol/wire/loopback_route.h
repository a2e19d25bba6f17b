#pragma once

#include <vector>

namespace tandem::wire {

/// Makes the sockets that liblcm sends from send through the loopback interface, for runs that
/// stay on one host (ttl 0). A route of the group through a network card cuts every message into
/// frames of its MTU: three times the time for 60 kB. liblcm does not tell its socket: it is the
/// one that is there after lcm_create() and was not before.
///
///   LoopbackRoute route;  lcm_create(…);  route.apply();
///
/// It then leaves the group on the route's interface, which liblcm joins also to send. Listeners
/// need not care: as long as this object lives, the group is joined on the loopback interface, and
/// LCM's sockets hear a group on every interface. Where there is no such interface the sockets
/// stay as they are.
class LoopbackRoute {
 public:
  LoopbackRoute();
  ~LoopbackRoute();
  LoopbackRoute(const LoopbackRoute&) = delete;
  LoopbackRoute& operator=(const LoopbackRoute&) = delete;

  void apply();

  /// The same for lcm_subscribe(): the sockets that are there after it hear the group on `port` on
  /// the loopback interface alone.
  void listen(int port);

 private:
  std::vector<int> before_;  ///< datagram sockets of this process
  int membership_ = -1;
};

}  // namespace tandem::wire
