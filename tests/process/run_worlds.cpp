#include <gtest/gtest.h>
#include <signal.h>

#include <map>

#include "tests/support/tandem_process.h"
#include "tests/support/two_worlds.h"

// Several multibody worlds, each in a process of its own, joined by flexible bodies: the bits of
// one process on every transport, each world replayed without the others, and whoever is lost is
// named.
namespace tandem::test {
namespace {

struct Worlds {
  explicit Worlds(int links) : scenario(two_worlds(links, folder)) {}

  [[nodiscard]] std::vector<std::string> command(const std::string& name,
                                                 const std::vector<std::string>& more) const {
    std::vector<std::string> all{kTandem,           "run",
                                 scenario.string(), "--quiet",
                                 "--out",           (folder / name).string(),
                                 "--set",           "run.duration_s=0.02"};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  /// summary.json of a run that must end with 0.
  [[nodiscard]] nlohmann::json run(const std::string& name, const std::vector<std::string>& more,
                                   const Environment& environment = {}) const {
    const Ended ended = run_command(command(name, more), environment);
    EXPECT_EQ(ended.code, 0) << name << ": " << ended.output;
    return summary_of(folder / name);
  }

  TemporaryFolder folder{"tandem_worlds"};
  std::filesystem::path scenario;
};

Environment disturbed_worlds() {
  return with_preload({{"TANDEM_FAULT_SEED", "5"},
                       {"TANDEM_FAULT_DROP_PERCENT", "3"},
                       {"TANDEM_FAULT_DUPLICATE_PERCENT", "3"},
                       {"TANDEM_FAULT_REORDER_PERCENT", "3"}},
                      TANDEM_FAULT_SHIM);
}

class RunWorlds : public testing::TestWithParam<int> {};

TEST_P(RunWorlds, HaveTheBitsOfOneProcess) {
  const Worlds worlds(GetParam());
  const auto expected = worlds.run("inproc", {"--transport", "inproc"});
  ASSERT_TRUE(expected.contains("state_hash"));
  const std::map<std::string, std::pair<std::vector<std::string>, Environment>> ways{
      {"lcm", {{}, {}}},
      {"hub", {{"--driver", "orchestrator"}, {}}},
      {"lossy", {{}, disturbed_worlds()}},
      {"lossy_hub", {{"--driver", "orchestrator"}, disturbed_worlds()}}};
  for (const auto& [name, way] : ways) {
    const auto summary = worlds.run(name, way.first, way.second);
    EXPECT_EQ(summary.value("state_hash", ""), expected.at("state_hash")) << name;
    EXPECT_EQ(summary["iterations"]["total"], expected["iterations"]["total"]) << name;
    for (const std::string world : {"near", "far"}) {
      EXPECT_EQ(summary["worlds"][world]["state_hash"], expected["worlds"][world]["state_hash"])
          << name << " " << world;
      const std::string table = world + "/bodies.csv";
      EXPECT_EQ(read_file(worlds.folder / name / table),
                read_file(worlds.folder / "inproc" / table))
          << name << " " << world;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Links, RunWorlds, testing::Values(1, 2));

TEST(RunWorldsReplay, EachIsReplayedWithoutTheOthers) {
  const Worlds worlds(2);
  (void)worlds.run("run", {});
  for (const std::string transport : {"lcm", "inproc"}) {
    for (const std::string side : {"near", "far", "mbs", "link2"}) {
      const Ended replay = tandem_command(
          {"replay", (worlds.folder / "run").string(), "--side", side, "--transport", transport});
      EXPECT_EQ(replay.code, 0) << side << ": " << replay.output;
      EXPECT_NE(replay.output.find("replay of " + side + " reproduces the log bit for bit"),
                std::string::npos)
          << replay.output;
    }
  }
  const Ended unknown =
      tandem_command({"replay", (worlds.folder / "run").string(), "--side", "fra"});
  EXPECT_EQ(unknown.code, 2);
  EXPECT_NE(unknown.output.find("Did you mean 'far'?"), std::string::npos) << unknown.output;
}

/// The process of a world of a run that makes macro steps; 0: it did not come to that.
pid_t process_of(const Worlds& worlds, const std::string& world) {
  const std::string mark = "--world" + std::string(1, '\0') + world;
  const std::filesystem::path log = worlds.folder / "run" / "exchange.lcm";
  for (int i = 0; i < 2000; ++i) {
    if (std::filesystem::exists(log) && std::filesystem::file_size(log) > 50000) {
      for (const pid_t pid : processes_with(worlds.folder.path().string())) {
        const std::string line = read_file("/proc/" + std::to_string(pid) + "/cmdline");
        if (line.find(mark) != std::string::npos) return pid;
      }
    }
    usleep(5000);
  }
  return 0;
}

// The world that drives, the other one, and either under the hub: named, and nothing is left.
TEST(RunWorldsFailures, TheLostWorldIsNamed) {
  for (const std::string how : {"kill", "stop"}) {
    for (const std::string driver : {"mbs", "orchestrator"}) {
      for (const std::string world : {"near", "far"}) {
        const Worlds worlds(1);
        ChildProcess tandem(worlds.command("run", {"--driver", driver, "--set", "run.duration_s=60",
                                                   "--set", "wire.timeout_s=1"}));
        const pid_t victim = process_of(worlds, world);
        ASSERT_GT(victim, 0) << world;
        kill(victim, how == "kill" ? SIGKILL : SIGSTOP);
        EXPECT_EQ(tandem.wait(15.0), 4) << tandem.output();
        EXPECT_NE(tandem.output().find("tandem-mbs " + world), std::string::npos)
            << how << " " << driver << ": " << tandem.output();
        EXPECT_TRUE(processes_with(worlds.folder.path().string()).empty()) << how << " " << world;
        EXPECT_EQ(tandem_command({"log", (worlds.folder / "run").string()}).code, 0);
      }
    }
  }
}

// Which world computes how long, and what each holds, stand in the summary; they add up.
TEST(RunWorldsBooks, AreThoseOfEachWorld) {
  const Worlds worlds(1);
  const auto summary = worlds.run("run", {});
  double interface_J = 0.0;
  for (const std::string world : {"near", "far"}) {
    const auto& own = summary.at("worlds").at(world);
    EXPECT_GT(own.at("compute_s").get<double>(), 0.0);
    EXPECT_EQ(own.at("state_hash").get<std::string>().size(), 16U);
    interface_J += own.at("energy_J").at("interface_work").get<double>();
  }
  const double all_J = summary.at("energy_J").at("mbs").at("interface_work").get<double>();
  EXPECT_NEAR(interface_J, all_J, 1e-12 * std::abs(all_J)) << "a sum of two numbers";
}

// The ledger adds up although one world computes in the driver's process and one elsewhere: to the
// 2 % that it promises.
TEST(RunWorldsBooks, TheLedgerAddsUp) {
  const auto summary = Worlds(1).run("run", {"--set", "run.duration_s=0.2"});
  double sum_s = 0.0;
  for (const auto& [part, seconds] : summary.at("ledger_s").items()) {
    if (part != "discarded") sum_s += (part == "overlap" ? -1.0 : 1.0) * seconds.get<double>();
  }
  EXPECT_NEAR(sum_s, summary.at("wall_s").get<double>(), 0.02 * sum_s);
  EXPECT_LT(std::abs(summary["ledger_s"]["other"].get<double>()), 0.05 * sum_s);
}

// Each world writes into a folder of its name and speaks in a log of its name.
TEST(RunWorldsFiles, EachHasItsOwn) {
  const Worlds worlds(1);
  (void)worlds.run("run", {"--set", "mbs.far.erp=0.3"});
  const std::filesystem::path run = worlds.folder / "run";
  EXPECT_FALSE(std::filesystem::exists(run / "bodies.csv"));
  EXPECT_NE(read_file(run / "far" / "bodies.csv").find("block.p_x_m"), std::string::npos);
  EXPECT_EQ(read_file(run / "near" / "bodies.csv").find("block.p_x_m"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(run / "far.log"));
  EXPECT_TRUE(std::filesystem::exists(run / "near.log"));
}

// The other commands know of worlds, too.
TEST(RunWorldsCommands, ReadTheirRuns) {
  const Worlds worlds(2);
  (void)worlds.run("run", {});
  const std::string run = (worlds.folder / "run").string();
  const Ended check = tandem_command(
      {"check", worlds.scenario.string(), "--graph", (worlds.folder / "graph.svg").string()});
  EXPECT_EQ(check.code, 0) << check.output;
  EXPECT_NE(check.output.find("world 'far': tip1, root2\n"), std::string::npos) << check.output;
  EXPECT_NE(read_file(worlds.folder / "graph.svg").find("tandem-mbs far: 2 rigid bodies"),
            std::string::npos);
  const Ended trace = tandem_command({"trace", run});
  EXPECT_EQ(trace.code, 0) << trace.output;
  EXPECT_NE(trace.output.find("tandem-mbs near (driver)"), std::string::npos) << trace.output;
  EXPECT_NE(trace.output.find("far "), std::string::npos) << trace.output;
  EXPECT_EQ(tandem_command({"report", run}).code, 0);
  EXPECT_EQ(tandem_command({"log", run}).code, 0);
  const Ended compare =
      tandem_command({"compare", worlds.scenario.string(), "--set", "run.duration_s=0.02", "--out",
                      (worlds.folder / "compare").string()});
  EXPECT_EQ(compare.code, 0) << compare.output;
  EXPECT_NE(compare.output.find("every port value has the same bits"), std::string::npos)
      << compare.output;
}

// A flexible body with ports in two worlds is held against both.
TEST(RunWorldsCommands, CheckWarnsOfEachPair) {
  const Worlds worlds(1);
  const Ended check = tandem_command(
      {"check", worlds.scenario.string(), "--set", "mbs.far.gravity_m_per_s2=[0, 0, -1]"});
  EXPECT_EQ(check.code, 0) << check.output;
  EXPECT_NE(check.output.find("mbs.far.gravity_m_per_s2"), std::string::npos) << check.output;
  EXPECT_EQ(check.output.find("mbs.near.gravity_m_per_s2"), std::string::npos) << check.output;
}

TEST(RunWorldsCommands, AdviceIsGiven) {
  const Worlds worlds(1);
  const Ended advise =
      tandem_command({"advise", worlds.scenario.string(), "--set", "run.duration_s=0.02", "--out",
                      (worlds.folder / "advice").string()});
  EXPECT_EQ(advise.code, 0) << advise.output;
}

// What cannot be computed is refused by name.
TEST(RunWorldsRefusals, NameThePlace) {
  const Worlds worlds(1);
  const std::string text = read_file(worlds.scenario);
  const auto refused = [&](const std::string& from, const std::string& to) {
    std::string changed = text;
    changed.replace(changed.find(from), from.size(), to);
    write_file(worlds.folder / "bad.yaml", changed);
    const Ended check = tandem_command({"check", (worlds.folder / "bad.yaml").string()});
    EXPECT_EQ(check.code, 2) << check.output;
    return check.output;
  };
  EXPECT_NE(refused("body1: bob2, body2: block", "body1: bob2, body2: crank")
                .find("mbs.far.joints.bob2_pin.body2: 'crank' is a body of world 'near', and this "
                      "is world 'far': worlds are coupled through flexible bodies only."),
            std::string::npos);
  EXPECT_NE(refused("body1: bob2, body2: block", "body1: bob2, body2: blck")
                .find("mbs.far.joints.bob2_pin.body2: there is no body 'blck'. Did you mean "
                      "'block'?"),
            std::string::npos);
  EXPECT_NE(refused("      - {name: bob2",
                    "      - {name: crank, mass_kg: 1, inertia_kg_m2: [1, 1, 1]}\n"
                    "      - {name: bob2")
                .find("mbs.far.bodies.crank.name: 'crank' is a body of world 'near' as well."),
            std::string::npos);
  EXPECT_NE(refused("fem:\n",
                    "  - {name: idle, bodies: [{name: b, mass_kg: 1, inertia_kg_m2: "
                    "[1, 1, 1]}]}\nfem:\n")
                .find("mbs.idle.name: no port is on a body of 'idle'"),
            std::string::npos);
  const std::string program = without_spaces(TANDEM_BIN_DIR) + "/tandem-mbs";
  const Ended missing = run_command(
      {program, "--scenario", worlds.scenario.string(), "--run", "1", "--port", "12345"});
  EXPECT_EQ(missing.code, 2);
  EXPECT_NE(missing.output.find("--world: is missing. The scenario has several multibody worlds: "
                                "near, far."),
            std::string::npos)
      << missing.output;
}

}  // namespace
}  // namespace tandem::test
