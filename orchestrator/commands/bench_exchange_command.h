#pragma once

namespace CLI {
class App;
}

namespace tandem::orchestrator {

/// `tandem bench exchange`: what one exchange costs, beside raw TCP and UDP between the same two
/// processes in the same run. As JSON:
///   rows: [{nodes, placement, path, raw_tcp_us, raw_udp_us, exchange_us, record_us, step_us:
///           {median, p90, p99, mean}, ratio_tcp, ratio_udp, resent, round_trips}]
/// `path`: direct or hub (all through the orchestrator), "+liblcm" where liblcm receives.
void add_bench_exchange(CLI::App& bench);

}  // namespace tandem::orchestrator
