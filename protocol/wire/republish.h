#pragma once

#include <cstdint>
#include <string>

#include "protocol/wire/event_log.h"

namespace tandem::wire {

/// Publishes the events of a log again on LCM with the time distances of the recording, at most 10
/// s of it between two of them (its clock may have jumped), for other listeners (lcm-spy, viewers).
/// `url` as for lcm_create(), empty = LCM's default; `speed` 2 = twice as fast, 0 = without pauses.
/// Runs in progress ignore it: the run id is that of the recording. Returns the number of events.
/// Throws a System error when LCM cannot publish.
std::int64_t republish(LogReader& log, const std::string& url, double speed);

}  // namespace tandem::wire
