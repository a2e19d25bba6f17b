#include "protocol/wire/republish.h"

#include <fmt/format.h>
#include <lcm/lcm.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <optional>
#include <thread>

#include "protocol/contract/error.h"

namespace tandem::wire {

namespace {

// Time stamps are of the wall clock, which is set now and then: a jump is not waited out.
constexpr std::int64_t kLongestPause_us = 10'000'000;

}  // namespace

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
  std::optional<std::int64_t> before_us;
  std::int64_t due_us = 0;
  std::int64_t published = 0;
  while (const auto event = log.next_raw()) {
    due_us += std::clamp<std::int64_t>(event->time_us - before_us.value_or(event->time_us), 0,
                                       kLongestPause_us);
    before_us = event->time_us;
    if (speed > 0.0) {
      const auto wait_us = static_cast<std::int64_t>(static_cast<double>(due_us) / speed);
      std::this_thread::sleep_until(start + std::chrono::microseconds(wait_us));
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
