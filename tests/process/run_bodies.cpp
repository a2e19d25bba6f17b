#include <gtest/gtest.h>
#include <signal.h>

#include <algorithm>
#include <map>

#include "protocol/wire/event_log.h"
#include "tests/support/chain_of_links.h"
#include "tests/support/columns.h"
#include "tests/support/tandem_process.h"

// Several flexible bodies, each in a process of its own: the bits of one process on every
// transport, the trajectory of the monolithic step, each body replayed without the others, and
// whoever is lost is named.
namespace tandem::test {
namespace {

struct Chain {
  explicit Chain(int links, const std::string& ends = "blocks")
      : scenario(chain_of(links, folder, ends)) {}

  [[nodiscard]] std::vector<std::string> command(const std::string& name,
                                                 const std::vector<std::string>& more) const {
    std::vector<std::string> all{kTandem,           "run",
                                 scenario.string(), "--quiet",
                                 "--out",           (folder / name).string(),
                                 "--set",           "run.duration_s=0.02"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  /// summary.json of a run that must end with `code`.
  [[nodiscard]] nlohmann::json run(const std::string& name, const std::vector<std::string>& more,
                                   const Environment& environment = {}, int code = 0) const {
    const Ended ended = run_command(command(name, more), environment);
    EXPECT_EQ(ended.code, code) << name << ": " << ended.output;
    return summary_of(folder / name);
  }

  TemporaryFolder folder{"tandem_bodies"};
  std::filesystem::path scenario;
};

Environment disturbed() {
  return with_preload({{"TANDEM_FAULT_SEED", "5"},
                       {"TANDEM_FAULT_DROP_PERCENT", "3"},
                       {"TANDEM_FAULT_DUPLICATE_PERCENT", "3"},
                       {"TANDEM_FAULT_REORDER_PERCENT", "3"}},
                      TANDEM_FAULT_SHIM);
}

class RunBodies : public testing::TestWithParam<int> {};

void expect_bits_of_one_process(const Chain& chain) {
  const auto expected = chain.run("inproc", {"--transport", "inproc"});
  ASSERT_TRUE(expected.contains("state_hash"));
  const std::map<std::string, std::pair<std::vector<std::string>, Environment>> ways{
      {"lcm", {{}, {}}},
      {"hub", {{"--driver", "orchestrator"}, {}}},
      {"lossy", {{}, disturbed()}},
      {"lossy_hub", {{"--driver", "orchestrator"}, disturbed()}}};
  for (const auto& [name, way] : ways) {
    const auto summary = chain.run(name, way.first, way.second);
    EXPECT_EQ(summary.value("state_hash", ""), expected.at("state_hash")) << name;
    EXPECT_EQ(summary["iterations"]["total"], expected["iterations"]["total"]) << name;
  }
}

TEST_P(RunBodies, HaveTheBitsOfOneProcess) { expect_bits_of_one_process(Chain(GetParam())); }

// Without rigid bodies: hinges between frames that have no mass.
TEST(RunJunctions, HaveTheBitsOfOneProcess) { expect_bits_of_one_process(Chain(3, "junctions")); }

TEST(RunJunctions, AreReplayedSideBySide) {
  const Chain chain(2, "junctions");
  (void)chain.run("run", {});
  for (const std::string side : {"link1", "link2", "mbs"}) {
    const Ended replay =
        tandem_command({"replay", (chain.folder / "run").string(), "--side", side});
    EXPECT_EQ(replay.code, 0) << side << ": " << replay.output;
  }
}

// What stands in, and springs, are held against what the flexible bodies hold there: 0.15 kg.
TEST(RunJunctions, AreCheckedAgainstTheFlexibleBodies) {
  const Chain chain(2, "junctions");
  const auto checked = [&](const std::vector<std::string>& sets) {
    std::vector<std::string> arguments{"check", chain.scenario.string()};
    for (const std::string& set : sets) arguments.insert(arguments.end(), {"--set", set});
    const Ended ended = tandem_command(arguments);
    EXPECT_EQ(ended.code, 0) << ended.output;
    return ended.output;
  };
  const std::string sound = checked({"mbs.integrator=verlet"});
  EXPECT_EQ(sound.find("stands in with"), std::string::npos) << sound;
  EXPECT_EQ(sound.find("too stiff or too damped"), std::string::npos) << sound;
  const std::string heavy =
      checked({"mbs.integrator=verlet", "mbs.junctions.tip1.stand_in_mass_kg=1000"});
  EXPECT_NE(heavy.find("mbs.junctions.tip1.stand_in_mass_kg: stands in with 1e+03 kg"),
            std::string::npos)
      << heavy;
  const std::string stiff =
      checked({"mbs.joint_springs=[{name: coil, joint: hinge2, stiffness_Nm_per_rad: 1e5}]"});
  EXPECT_NE(stiff.find("spring 'coil' is too stiff or too damped"), std::string::npos) << stiff;
}

TEST(RunJunctions, AreRefusedByNameWhereNothingIterates) {
  const Chain chain(1, "junctions");
  for (const std::string scheme : {"explicit_serial", "explicit_parallel", "tlm"}) {
    const Ended refused = run_command(chain.command("run", {"--set", "coupling.scheme=" + scheme}));
    EXPECT_EQ(refused.code, 2) << refused.output;
    EXPECT_NE(refused.output.find("mbs.junctions have no mass"), std::string::npos)
        << refused.output;
  }
}

INSTANTIATE_TEST_SUITE_P(Links, RunBodies, testing::Values(1, 2, 4, 8, 16));

/// How often a body had answered before the one in front of it, in all evaluations of a log.
int overtakings(const std::filesystem::path& log_file) {
  int count = 0;
  wire::LogReader log(log_file);
  while (const auto step = log.next_step()) {
    for (const wire::CallRecord& call : step->calls) {
      const std::vector<wire::PartTimes>& parts = call.times.parts;
      for (std::size_t b = 1; b < parts.size(); ++b) {
        count += parts[b].arrived_s < parts[b - 1].arrived_s ? 1 : 0;
      }
    }
  }
  return count;
}

// Each process sleeps up to 2 ms before whatever it sends: the bodies answer in random order.
TEST(RunBodiesOrder, OfTheAnswersChangesNoBit) {
  const Chain chain(4);
  const auto expected = chain.run("inproc", {"--transport", "inproc"});
  const Environment sleepy{{"TANDEM_FAULT_SLEEP_US", "2000"}};
  Environment lossy = sleepy;
  for (const char* what : {"DROP", "DUPLICATE", "REORDER"}) {
    lossy[std::string("TANDEM_FAULT_") + what + "_PERCENT"] = "5";
  }
  const std::map<std::string, std::pair<std::vector<std::string>, Environment>> ways{
      {"sleepy", {{}, sleepy}},
      {"sleepy_hub", {{"--driver", "orchestrator"}, sleepy}},
      {"sleepy_lossy", {{}, lossy}}};
  for (const auto& [name, way] : ways) {
    const auto summary = chain.run(name, way.first, with_preload(way.second, TANDEM_FAULT_SHIM));
    EXPECT_EQ(summary.value("state_hash", ""), expected.at("state_hash")) << name;
    const int evaluations = summary["iterations"]["total"].get<int>();
    // By chance every second pair: 1/8 is far below what a draw of so many can give.
    EXPECT_GT(overtakings(chain.folder / name / "exchange.lcm"), 3 * evaluations / 8) << name;
  }
}

// One message asks all of them: 1 + N an evaluation.
TEST(RunBodiesCost, OneMessageAsksAll) {
  const auto summary = Chain(4).run("run", {});
  const auto& wire = summary.at("wire");
  // A side that the scheduler keeps for 20 ms is asked once more, and answers once more.
  const int repeated = wire.at("resent").get<int>() + wire.at("duplicates").get<int>();
  const int expected = 5 * summary["iterations"]["total"].get<int>();
  EXPECT_GE(wire.at("messages").get<int>(), expected);
  EXPECT_LE(wire.at("messages").get<int>(), expected + 2 * repeated);
}

// The iterations do not grow with the number of bodies: all of them are in one Newton step.
TEST(RunBodiesCost, IterationsDoNotGrowWithTheirNumber) {
  std::vector<double> means;
  for (const int links : {1, 4, 8}) {
    const auto summary =
        Chain(links).run("run", {"--transport", "inproc", "--set", "run.duration_s=0.1"});
    means.push_back(summary.at("iterations").at("mean").get<double>());
  }
  // 100 steps, of which the first learn the Jacobians.
  EXPECT_LE(*std::max_element(means.begin(), means.end()), 2.5) << means[0] << " " << means[2];
}

TEST(RunBodiesReplay, EachIsReplayedWithoutTheOthers) {
  const Chain chain(3);
  (void)chain.run("run", {});
  for (const std::string transport : {"lcm", "inproc"}) {
    for (const std::string side : {"link1", "link3", "fem", "mbs"}) {
      const Ended replay = tandem_command(
          {"replay", (chain.folder / "run").string(), "--side", side, "--transport", transport});
      EXPECT_EQ(replay.code, 0) << side << ": " << replay.output;
      EXPECT_NE(replay.output.find("replay of " + side + " reproduces the log bit for bit"),
                std::string::npos)
          << replay.output;
    }
  }
  const Ended unknown =
      tandem_command({"replay", (chain.folder / "run").string(), "--side", "lnik2"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_NE(unknown.output.find("Did you mean 'link2'?"), std::string::npos) << unknown.output;
}

// Every process of the run, killed or frozen in the middle: named, and nothing is left.
TEST(RunBodiesFailures, TheLostBodyIsNamed) {
  for (const std::string how : {"kill", "stop"}) {
    for (const std::string link : {"link1", "link2"}) {
      const Chain chain(2);
      ChildProcess tandem(
          chain.command("run", {"--set", "run.duration_s=60", "--set", "wire.timeout_s=1"}));
      const std::string mark = "--body" + std::string(1, '\0') + link;
      std::vector<pid_t> victims;
      for (int i = 0; i < 200 && victims.empty(); ++i) {
        if (std::filesystem::exists(chain.folder / "run" / "bus.json")) {
          for (const pid_t pid : processes_with(chain.folder.path().string())) {
            const std::string line = read_file("/proc/" + std::to_string(pid) + "/cmdline");
            if (line.find(mark) != std::string::npos) victims.push_back(pid);
          }
        }
        usleep(20000);
      }
      ASSERT_EQ(victims.size(), 1U) << link;
      usleep(500000);
      kill(victims.front(), how == "kill" ? SIGKILL : SIGSTOP);
      EXPECT_EQ(tandem.wait(15.0), 4) << tandem.output();
      EXPECT_NE(tandem.output().find("tandem-fem " + link), std::string::npos) << tandem.output();
      EXPECT_TRUE(processes_with(chain.folder.path().string()).empty()) << how << " " << link;
      EXPECT_EQ(tandem_command({"log", (chain.folder / "run").string()}).code, 0);
    }
  }
}

// Which body computes how long, and what each holds, stand in the summary; they add up.
TEST(RunBodiesBooks, AreThoseOfEachBody) {
  const Chain chain(2);
  const auto summary = chain.run("run", {});
  double interface_J = 0.0;
  for (const std::string link : {"link1", "link2"}) {
    const auto& body = summary.at("bodies").at(link);
    EXPECT_GT(body.at("compute_s").get<double>(), 0.0);
    EXPECT_EQ(body.at("state_hash").get<std::string>().size(), 16U);
    interface_J += body.at("energy_J").at("interface_work").get<double>();
  }
  const double all_J = summary.at("energy_J").at("fem").at("interface_work").get<double>();
  EXPECT_NEAR(interface_J, all_J, 1e-12 * std::abs(all_J)) << "a sum of two numbers";
}

// energy.csv has the book of each body behind those of the sides, on every transport the same.
TEST(RunBodiesBooks, AreInTheTableOfEnergiesAtEveryStep) {
  const Chain chain(3);
  const std::vector<std::string> every{"--set", "output.energy_every_steps=1"};
  (void)chain.run("lcm", every);
  (void)chain.run("here", {"--transport", "inproc", "--set", "output.energy_every_steps=1"});
  EXPECT_EQ(read_file(chain.folder / "lcm/energy.csv"),
            read_file(chain.folder / "here/energy.csv"));
  const Columns columns = read_columns(chain.folder / "lcm/energy.csv");
  for (const char* entry : {"kinetic_J", "elastic_J", "potential_J", "interface_work_J"}) {
    const std::vector<double>& all = columns.at(std::string("fem.") + entry);
    ASSERT_EQ(all.size(), 21U);
    for (std::size_t row = 0; row < all.size(); ++row) {
      double sum = 0.0;
      for (const char* link : {"link1.", "link2.", "link3."}) {
        sum += columns.at(link + std::string(entry)).at(row);
      }
      EXPECT_NEAR(sum, all[row], 1e-12 * (1.0 + std::abs(all[row]))) << entry << " " << row;
    }
  }
}

TEST(RunBodiesControl, CommandsSayWhichBody) {
  const Chain chain(2);
  ChildProcess tandem(
      chain.command("run", {"--set", "run.duration_s=30", "--set", "run.pace=real_time"}));
  Ended asked;
  for (int i = 0; i < 100; ++i) {
    usleep(50000);
    asked = tandem_command(
        {"control", (chain.folder / "run").string(), "--body", "link2", "force", "right", "0,0,1"});
    if (asked.code == 0) break;
  }
  EXPECT_EQ(asked.code, 0) << asked.output;
  EXPECT_NE(asked.output.find("link2"), std::string::npos) << asked.output;
  const Ended refused =
      tandem_command({"control", (chain.folder / "run").string(), "force", "right", "0,0,1"});
  EXPECT_NE(refused.code, 0);
  EXPECT_NE(refused.output.find("Name it with --body: link1, link2."), std::string::npos)
      << refused.output;
  tandem.signal(SIGINT);
  EXPECT_EQ(tandem.wait(15.0), 130) << tandem.output();
  // The command is in the log, and is made again for its own body alone.
  for (const std::string link : {"link1", "link2"}) {
    const Ended replay = tandem_command(
        {"replay", (chain.folder / "run").string(), "--side", link, "--transport", "inproc"});
    EXPECT_EQ(replay.code, 0) << link << ": " << replay.output;
  }
}

// Each body writes into a folder of its name.
TEST(RunBodiesFiles, EachHasItsOwnFolder) {
  const Chain chain(2);
  (void)chain.run("run",
                  {"--set", "output.vtu_every_steps=10", "--set", "fem.link2.watch=[right]"});
  EXPECT_TRUE(std::filesystem::exists(chain.folder / "run" / "link1" / "fem"));
  EXPECT_FALSE(std::filesystem::exists(chain.folder / "run" / "link1" / "watch.csv"));
  EXPECT_TRUE(std::filesystem::exists(chain.folder / "run" / "link2" / "watch.csv"));
  EXPECT_TRUE(std::filesystem::exists(chain.folder / "run" / "link2.log"));
}

}  // namespace
}  // namespace tandem::test
