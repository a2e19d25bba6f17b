#include "protocol/driver/standard_streams.h"

#include <fcntl.h>
#include <unistd.h>

namespace tandem {

void open_standard_streams() {
  for (int fd = STDIN_FILENO; fd <= STDERR_FILENO; ++fd) {
    if (fcntl(fd, F_GETFD) >= 0) continue;
    // The lowest free number is given: that is fd, as those below are open by now.
    if (open("/dev/null", O_RDWR) < 0) return;
  }
}

}  // namespace tandem
