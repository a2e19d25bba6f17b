#include <CLI/CLI.hpp>
#include <cstdio>
#include <memory>
#include <string>

#include "orchestrator/commands/commands.h"
#include "orchestrator/files/run_directory.h"
#include "orchestrator/record/replay.h"
#include "orchestrator/scenario/option_checks.h"
#include "protocol/contract/error.h"
#include "protocol/wire/event_log.h"
#include "protocol/wire/republish.h"

namespace tandem::orchestrator {
namespace {

struct ReplayCommand {
  std::string run;
  std::string side;
  std::string transport = "lcm";
  double tolerance = 0.0;
  bool publish = false;
  double speed = 1.0;
  std::string url;

  int replay_command() const {
    const RunDirectory directory = RunDirectory::open(run);
    require(publish != !side.empty(), "replay: choose one of --side SIDE and --publish");
    if (publish) return publish_log(directory);
    const ReplayReport report =
        replay(directory, {.side = side,
                           .mode = transport == "lcm" ? Mode::Lcm : Mode::Inproc,
                           .tolerance = tolerance});
    if (!report.difference.empty()) {
      throw Error(ErrorKind::ReplayDiffers, "replay: " + report.difference);
    }
    std::printf(
        "replay of %s reproduces the log%s: %lld macro steps, %lld calls (%lld discarded)\n",
        side.c_str(), tolerance > 0.0 ? " within the tolerance" : " bit for bit",
        static_cast<long long>(report.macro_steps), static_cast<long long>(report.calls),
        static_cast<long long>(report.discarded_calls));
    if (!report.remark.empty()) std::fprintf(stderr, "note: %s\n", report.remark.c_str());
    return 0;
  }

  int publish_log(const RunDirectory& directory) const {
    require_whole_log(directory);
    wire::LogReader log(directory.log());
    const std::int64_t events = wire::republish(log, url, speed);
    std::printf("published %lld events\n", static_cast<long long>(events));
    return 0;
  }
};

}  // namespace

void add_replay(CLI::App& app, int& exit_code) {
  auto command = std::make_shared<ReplayCommand>();
  CLI::App* sub = app.add_subcommand(
      "replay", "Drive one real side from a run's log, or publish the log on LCM again");
  sub->add_option("RUN", command->run, "Run folder")->required();
  sub->add_option(
      "--side", command->side,
      "Side to drive: mbs, fem, or the name of one of several worlds or flexible bodies");
  sub->add_option("--tolerance", command->tolerance,
                  "Allowed difference relative to max(1, |logged|); 0 = the same bits")
      ->check(number_from_zero())
      ->capture_default_str();
  sub->add_option("--transport", command->transport, "lcm: a side process; inproc: none")
      ->check(CLI::IsMember({"lcm", "inproc"}))
      ->capture_default_str();
  CLI::Option* publish =
      sub->add_flag("--publish", command->publish, "Publish the log's events on LCM");
  sub->add_option("--speed", command->speed, "With --publish: 2 = twice as fast, 0 = no pauses")
      ->check(number_from_zero())
      ->needs(publish)
      ->capture_default_str();
  sub->add_option("--url", command->url,
                  "With --publish: LCM URL [LCM_DEFAULT_URL, else LCM's own]")
      ->needs(publish);
  sub->footer(
      "Exit code 5 and the first differing step, port and component when a replay differs.");
  sub->callback([command, &exit_code] { exit_code = command->replay_command(); });
}

}  // namespace tandem::orchestrator
