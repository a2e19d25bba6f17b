#include "protocol/wire/receiver.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <random>

#include "protocol/contract/error.h"

namespace tandem::wire {

void require_multicast_route(int port) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  require(fd >= 0, fmt::format("wire: cannot open a socket: {}", std::strerror(errno)));
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(static_cast<std::uint16_t>(port));
  inet_pton(AF_INET, kGroup, &address.sin_addr);
  const int result = connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address));
  const int error = errno;
  close(fd);
  if (result == 0) return;
  throw Error(
      ErrorKind::System,
      fmt::format("wire: no route to the multicast group {} ({}). On one host: `ip route add "
                  "224.0.0.0/4 dev lo`; between hosts route it to the common network.",
                  kGroup, std::strerror(error)));
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
    const bool is_free =
        bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) == 0;
    close(fd);
    if (is_free) return port;
  }
  throw Error(ErrorKind::Usage, "wire: no free multicast port between 20000 and 59999");
}

}  // namespace tandem::wire
