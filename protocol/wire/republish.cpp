#include "protocol/wire/republish.h"

#include <fmt/format.h>
#include <lcm/lcm.h>

#include <chrono>
#include <memory>
#include <optional>
#include <thread>

#include "protocol/contract/error.h"

namespace tandem::wire {

std::int64_t republish(LogReader& log, const std::string& url, double speed) {
  require(url.empty() || url.find("://") != std::string::npos,
          fmt::format("--url: '{}' is no LCM URL. Write one like udpm://239.255.76.67:7667?ttl=0.",
                      url));
  const std::unique_ptr<lcm_t, decltype(&lcm_destroy)> lcm(
      lcm_create(url.empty() ? nullptr : url.c_str()), &lcm_destroy);
  if (!lcm) {
    throw Error(ErrorKind::System,
                fmt::format("cannot open LCM at '{}'. Without a multicast route: ip route add "
                            "224.0.0.0/4 dev lo",
                            url.empty() ? "the default URL" : url));
  }
  const auto start = std::chrono::steady_clock::now();
  std::optional<std::int64_t> first_us;
  std::int64_t published = 0;
  while (const auto event = log.next_raw()) {
    if (!first_us) first_us = event->time_us;
    if (speed > 0.0) {
      const double due_us = static_cast<double>(event->time_us - *first_us) / speed;
      std::this_thread::sleep_until(start +
                                    std::chrono::microseconds(static_cast<std::int64_t>(due_us)));
    }
    if (lcm_publish(lcm.get(), event->channel.c_str(), event->payload.data(),
                    static_cast<unsigned>(event->payload.size())) != 0) {
      throw Error(ErrorKind::System, fmt::format("cannot publish event {} on LCM", published));
    }
    ++published;
  }
  return published;
}

}  // namespace tandem::wire
