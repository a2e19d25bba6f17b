// The tracked vehicle over LCM has the bits of the run in one process, and either side can be
// replayed from the log.

#include <gtest/gtest.h>

#include <utility>

#include "tests/support/tandem_process.h"

namespace tandem::test {
namespace {

const std::vector<std::string> kShort{"--set", "run.duration_s=0.02", "--set",
                                      "output.vtu_every_steps=100"};

std::vector<std::string> with(std::vector<std::string> arguments,
                              const std::vector<std::string>& more) {
  arguments.insert(arguments.end(), more.begin(), more.end());
  return arguments;
}

TEST(AncfSameBits, VehicleOverLcmInProcessAndReplayed) {
  const TemporaryFolder folder;
  const Ended local = run_command(
      run_of("tracked_vehicle", folder / "inproc", with(kShort, {"--transport", "inproc"})));
  ASSERT_EQ(local.code, 0) << local.output;
  const Ended remote = run_command(run_of("tracked_vehicle", folder / "lcm", kShort));
  ASSERT_EQ(remote.code, 0) << remote.output;
  const auto here = summary_of(folder / "inproc");
  const auto there = summary_of(folder / "lcm");
  EXPECT_EQ(here.at("macro_steps"), 200);
  EXPECT_EQ(there.at("state_hash"), here.at("state_hash"));
  EXPECT_EQ(there.at("ports"), here.at("ports"));
  for (const char* file : {"beam.csv", "fem/fem_000200.vtu", "fem/fem.pvd"}) {
    EXPECT_TRUE(std::filesystem::exists(folder / "lcm" / file)) << file;
  }
  for (const char* side : {"fem", "mbs"}) {
    const Ended replay = tandem_command({"replay", (folder / "lcm").string(), "--side", side});
    EXPECT_EQ(replay.code, 0) << side << ": " << replay.output;
  }
}

TEST(AncfSameBits, ImplicitCouplingRollsBackExactly) {
  const TemporaryFolder folder;
  const std::vector<std::string> implicit{"--set", "run.duration_s=0.002", "--scheme", "implicit"};
  const Ended local = run_command(
      run_of("tracked_vehicle", folder / "inproc", with(implicit, {"--transport", "inproc"})));
  ASSERT_EQ(local.code, 0) << local.output;
  const Ended remote = run_command(run_of("tracked_vehicle", folder / "lcm", implicit));
  ASSERT_EQ(remote.code, 0) << remote.output;
  EXPECT_EQ(summary_of(folder / "lcm").at("state_hash"),
            summary_of(folder / "inproc").at("state_hash"));
}

TEST(AncfSameBits, RopeBetweenTwoBodies) {
  const TemporaryFolder folder;
  const std::vector<std::string> start{"--set", "run.duration_s=0.4"};
  const Ended local =
      run_command(run_of("rope_crane", folder / "inproc", with(start, {"--transport", "inproc"})));
  ASSERT_EQ(local.code, 0) << local.output;
  const Ended remote = run_command(run_of("rope_crane", folder / "lcm", start));
  ASSERT_EQ(remote.code, 0) << remote.output;
  EXPECT_EQ(summary_of(folder / "lcm").at("state_hash"),
            summary_of(folder / "inproc").at("state_hash"));
}

TEST(AncfInput, WhatDoesNotFitIsToldWithItsRemedy) {
  const TemporaryFolder folder;
  std::string example = "tracked_vehicle";
  const auto refused = [&](const std::string& setting, const std::string& cause,
                           const std::string& remedy) {
    const Ended ended = run_command(
        run_of(example, folder / "refused", {"--transport", "inproc", "--set", setting}));
    EXPECT_EQ(ended.code, 2) << setting << ": " << ended.output;
    EXPECT_NE(ended.output.find(cause), std::string::npos) << setting << ": " << ended.output;
    EXPECT_NE(ended.output.find(remedy), std::string::npos) << setting << ": " << ended.output;
    std::filesystem::remove_all(folder / "refused");
  };
  refused("fem.ancf.chain.elements=22", "do not match the links", "Use 9 teeth");
  refused("fem.ancf.wheels.1.radius_m=0.215", "reaches", "radii of a loop");
  refused("fem.ancf.wheels.1.port=idle", "names no port", "Did you mean 'idler'");
  refused("fem.ancf.grounds.0.point_m=[0, 0, 0.05]", "the ground reaches",
          "Raise the chain's path");
  refused("fem.ancf.settle.step_s=7e-5", "whole multiple", "step_s");
  refused("fem.ancf.attachments=[{port: idler, end: left}]", "has no ends", "closed chain");
  example = "rope_crane";
  refused("fem.ancf.chain.left_support=hinged", "held by chain.left_support",
          "Leave that one free");
  refused("fem.ancf.attachments.1.end=left", "attached already", "Use the other end");
  refused("fem.ancf.attachments.1.port=trolly", "names no port", "Did you mean 'trolley'");
}

TEST(AncfInput, AStepBeyondTheStableOneEndsWithCauseAndRemedy) {
  // In turn the torque of the idler swings from step to step, in parallel with four or five steps a
  // period, for the delay is twice as long.
  const TemporaryFolder folder;
  for (const auto& [scheme, step] : {std::pair{"explicit_serial", "run.macro_step_s=5e-4"},
                                     std::pair{"explicit_parallel", "run.macro_step_s=1e-4"}}) {
    const Ended ended = run_command(run_of("tracked_vehicle", folder / scheme,
                                           {"--transport", "inproc", "--scheme", scheme, "--set",
                                            step, "--set", "run.duration_s=0.1"}));
    EXPECT_EQ(ended.code, 3) << scheme << ": " << ended.output;
    EXPECT_NE(ended.output.find("port 'idler'"), std::string::npos) << ended.output;
    EXPECT_NE(ended.output.find("Shorten run.macro_step_s"), std::string::npos) << ended.output;
  }
}

}  // namespace
}  // namespace tandem::test
