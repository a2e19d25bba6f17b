// The `mbs` section of a scenario: what it means, and what is refused with its place in the file.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "mbs_process/bodies_csv.h"
#include "mbs_process/mbs_keys.h"
#include "protocol/contract/error.h"
#include "protocol/scenario/common_keys.h"
#include "protocol/scenario/scenario_file.h"
#include "tests/support/mbs_mechanisms.h"

namespace tandem::mbs::testing {
namespace {

const std::string kScenario = R"(name: test
run: {duration_s: 1, macro_step_s: 1e-3}
ports:
  - {name: eye, body: rod, node_set: eye, position_m: [1, 2, 3]}
mbs:
  gravity_m_per_s2: [0, -9.81, 0]
  micro_step_s: 5e-4
  erp: 0.3
  cfm: 1e-9
  bodies:
    - name: crank
      mass_kg: 2
      inertia_kg_m2: [1, 2, 2.5, 0.1, 0.2, 0.3]
      position_m: [0.1, 0, 0]
      orientation_wxyz: [0, 1, 0, 0]
      velocity_m_per_s: [1, 2, 3]
      angular_velocity_rad_per_s: [4, 5, 6]
    - {name: rod, mass_kg: 1, inertia_kg_m2: [1, 1, 1]}
  joints:
    - name: pin
      kind: hinge
      body1: crank
      anchor_m: [0, 0, 0]
      axis: [0, 0, 2]
      motor: {kind: speed, law: {kind: ramp, end_s: 1, value_end: 7}, max_torque_Nm: 5}
    - name: guide
      kind: slider
      body1: rod
      body2: crank
      axis: [1, 0, 0]
      limits: [{lower_m: -0.1, upper_m: 0.2}]
    - {name: ball, kind: ball, body1: rod, anchor_m: [1, 1, 1]}
  springs:
    - {name: s, body1: rod, point1_m: [1, 0, 0], point2_m: [2, 0, 0], stiffness_N_per_m: 10}
  joint_springs:
    - {name: coil, joint: pin, stiffness_Nm_per_rad: 3, damping_Nm_s_per_rad: 0.5, rest_rad: 0.1}
  forces:
    - {name: push, body: rod, point_B_m: [0, 1, 0], direction: [0, 0, 1], law: 4}
)";

class MbsKeys : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* test = ::testing::UnitTest::GetInstance()->current_test_info();
    folder_ =
        std::filesystem::temp_directory_path() / ("tandem_mbs_keys_" + std::string(test->name()));
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  [[nodiscard]] Params read(const std::string& text) const {
    const std::filesystem::path file = folder_ / "scenario.yaml";
    std::ofstream(file) << text;
    scenario::Section table;
    table.keys = scenario::root_keys();
    table.keys.push_back(scenario::run_keys());
    table.keys.push_back(scenario::ports_keys());
    table.keys.push_back(mbs_keys());
    return read_params(scenario::load(file, table).root);
  }

  /// The error for kScenario with `from` replaced by `to`.
  [[nodiscard]] std::string error_with(const std::string& from, const std::string& to) const {
    std::string text = kScenario;
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    text.replace(at, from.size(), to);
    try {
      (void)read(text);
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::Usage);
      return error.what();
    }
    return "no error";
  }

  std::filesystem::path folder_;
};

TEST_F(MbsKeys, EveryKeyArrives) {
  const Params params = read(kScenario);
  EXPECT_EQ(params.gravity_m_per_s2, Eigen::Vector3d(0.0, -9.81, 0.0));
  EXPECT_EQ(params.macro_step, SimTime(1'000'000));
  EXPECT_EQ(params.micro_step, SimTime(500'000));
  EXPECT_EQ(params.erp, 0.3);
  EXPECT_EQ(params.cfm, 1e-9);
  ASSERT_EQ(params.bodies.size(), 2U);
  const BodyParams& crank = params.bodies[0];
  EXPECT_EQ(crank.mass_kg, 2.0);
  EXPECT_EQ(crank.inertia_kg_m2, (std::array<double, 6>{1, 2, 2.5, 0.1, 0.2, 0.3}));
  EXPECT_EQ(crank.p_WB.x(), 0.1);
  EXPECT_EQ(crank.q_WB.x(), 1.0);
  EXPECT_EQ(crank.v_WB, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(crank.w_WB, Eigen::Vector3d(4, 5, 6));
  ASSERT_EQ(params.joints.size(), 3U);
  const JointParams& pin = params.joints[0];
  EXPECT_EQ(pin.kind, JointKind::Hinge);
  EXPECT_EQ(pin.body2, kWorld);
  EXPECT_EQ(pin.motor.value().max_effort, 5.0);
  EXPECT_EQ(pin.motor->law(0.5), 3.5);
  const JointParams& guide = params.joints[1];
  EXPECT_EQ(guide.body2, "crank");
  EXPECT_EQ(guide.limits.at(0).lower, -0.1);
  EXPECT_EQ(guide.limits.at(0).upper, 0.2);
  EXPECT_EQ(params.joints[2].p_WA, Eigen::Vector3d(1, 1, 1));
  EXPECT_EQ(params.springs.at(0).stiffness_N_per_m, 10.0);
  EXPECT_FALSE(params.springs[0].rest_length_m.has_value());
  EXPECT_EQ(params.joint_springs.at(0).damping, 0.5);
  EXPECT_EQ(params.joint_springs[0].rest, 0.1);
  EXPECT_EQ(params.forces.at(0).p_BF.y(), 1.0);
  EXPECT_EQ(params.forces[0].law(9.0), 4.0);
  EXPECT_EQ(params.ports.at(0).p_WP, Eigen::Vector3d(1, 2, 3));
  EXPECT_NO_THROW(check(params));
}

TEST_F(MbsKeys, DefaultsAreThoseOfTheParameters) {
  const Params params = read(R"(name: test
run: {duration_s: 1, macro_step_s: 1e-3}
ports: [{name: eye, body: rod, node_set: eye}]
mbs:
  bodies: [{name: rod, mass_kg: 1, inertia_kg_m2: [1, 1, 1]}]
)");
  const Params defaults;
  EXPECT_EQ(params.gravity_m_per_s2, defaults.gravity_m_per_s2);
  EXPECT_EQ(params.erp, defaults.erp);
  EXPECT_EQ(params.cfm, defaults.cfm);
  EXPECT_FALSE(params.micro_step.has_value());
  EXPECT_TRUE(params.joints.empty());
}

TEST_F(MbsKeys, FaultsAreReportedWithTheirPlace) {
  struct Fault {
    std::string from, to, said;
  };
  const std::vector<Fault> faults = {
      {"body: rod, node", "body: rot, node",
       "scenario.yaml:4:23: ports.eye.body: there is no body 'rot'. Did you mean 'rod'?"},
      {"body1: crank", "body1: crang", "Did you mean 'crank'?"},
      {"body2: crank", "body2: rod", "cannot be connected with itself"},
      {"axis: [0, 0, 2]", "axis: [0, 0, 0]", "axis: a hinge joint needs an axis"},
      {"micro_step_s: 5e-4", "micro_step_s: 3e-4", "scenario.yaml:7:"},
      {"inertia_kg_m2: [1, 1, 1]", "inertia_kg_m2: [1, 1, 3]", "triangle inequality"},
      {"inertia_kg_m2: [1, 1, 1]", "inertia_kg_m2: [1, 1, 1, 0]", "needs 3 or 6 numbers"},
      {"lower_m: -0.1, upper_m: 0.2", "lower_m: 0.2, upper_m: -0.1", "reversed"},
      {"lower_m: -0.1", "lower_rad: -0.1", "a slider's coordinate is a length"},
      {"max_torque_Nm: 5", "max_force_N: 5", "coordinate is an angle"},
      {"max_torque_Nm: 5", "axis: 2", "axis 2 does not exist"},
      {"anchor_m: [1, 1, 1]", "anchor_m: [1, 1, 1], motor: {kind: speed, law: 1}",
       "no axis to act on"},
      {"joint: pin", "joint: pim", "Did you mean 'pin'?"},
      {"joint: pin", "joint: pin, kind: axial", "axial"},
      {"direction: [0, 0, 1]", "direction: [0, 0, 0]", "direction"},
      {"orientation_wxyz: [0, 1, 0, 0]", "orientation_wxyz: [0, 2, 0, 0]", "scenario.yaml:15:"}};
  for (const Fault& fault : faults) {
    const std::string error = error_with(fault.from, fault.to);
    EXPECT_NE(error.find(fault.said), std::string::npos) << error << "\nlacks: " << fault.said;
    EXPECT_NE(error.find("scenario.yaml:"), std::string::npos) << error;
  }
}

// Frames without mass come after the bodies, by whose names they are referred to.
TEST_F(MbsKeys, JunctionsArrive) {
  const std::string text = R"(name: test
run: {duration_s: 1, macro_step_s: 1e-3}
ports: [{name: eye, body: knee, node_set: eye}]
mbs:
  junctions:
    - {name: knee, position_m: [1, 0, 0], velocity_m_per_s: [0, 2, 0], stand_in_mass_kg: 3}
)";
  const Params params = read(text);
  ASSERT_EQ(params.bodies.size(), 1U);
  const BodyParams& knee = params.bodies[0];
  EXPECT_TRUE(knee.massless);
  EXPECT_EQ(knee.p_WB, Eigen::Vector3d(1, 0, 0));
  EXPECT_EQ(knee.v_WB, Eigen::Vector3d(0, 2, 0));
  EXPECT_EQ(knee.mass_kg, 3.0);
  EXPECT_EQ(knee.inertia_kg_m2[0], 0.01);
  EXPECT_EQ(port_at(params, knee), 0U);
  EXPECT_NO_THROW(check(params));
}

TEST_F(MbsKeys, FaultsOfJunctionsAreReportedWithTheirPlace) {
  const std::string joints = "  joints:\n    - name: pin";
  const std::string junction = "  junctions: [{name: knee, position_m: [1, 2, 3]}]\n" + joints;
  std::string error = error_with(joints, junction);
  EXPECT_NE(error.find("mbs.junctions.knee.name: no port is on it"), std::string::npos) << error;
  EXPECT_NE(error.find("scenario.yaml:"), std::string::npos) << error;
  error = error_with(joints, "  junctions: [{name: rod, position_m: [1, 2, 3]}]\n" + joints);
  EXPECT_NE(error.find("'rod' is taken by a body"), std::string::npos) << error;
}

TEST_F(MbsKeys, BodiesCsvReadsBackToTheSameBits) {
  const std::filesystem::path file = folder_ / "bodies.csv";
  State state;
  state.bodies.resize(2);
  state.bodies[1].p_WB = {1.0 / 3.0, -1e-300, 12345678.9};
  {
    BodiesCsv csv(file, {"crank", "rod"}, 2);
    for (int i = 0; i < 5; ++i) {
      state.time = i * SimTime(1'000'000);
      csv.write(state);
      csv.write(state);  // a second checkpoint of the same state makes no row
    }
    csv.finish();
  }
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  EXPECT_EQ(line.substr(0, line.find(",rod.p_y_m")),
            "t_s,crank.p_x_m,crank.p_y_m,crank.p_z_m,crank.q_w,crank.q_x,crank.q_y,crank.q_z,"
            "crank.v_x_m_per_s,crank.v_y_m_per_s,crank.v_z_m_per_s,crank.w_x_rad_per_s,"
            "crank.w_y_rad_per_s,crank.w_z_rad_per_s,rod.p_x_m");
  std::vector<std::string> rows;
  while (std::getline(stream, line)) rows.push_back(line);
  ASSERT_EQ(rows.size(), 3U);  // every second of five
  std::istringstream last(rows.back());
  std::vector<double> values;
  for (std::string cell; std::getline(last, cell, ',');) values.push_back(std::stod(cell));
  ASSERT_EQ(values.size(), 27U);
  EXPECT_EQ(values[0], 0.004);
  EXPECT_EQ(values[14], 1.0 / 3.0);
  EXPECT_EQ(values[15], -1e-300);
  EXPECT_EQ(values[16], 12345678.9);
}

TEST_F(MbsKeys, BodiesCsvSaysWhichFileCannotBeWritten) {
  const std::filesystem::path missing = folder_ / "missing" / "bodies.csv";
  EXPECT_THROW(BodiesCsv(missing, {"rod"}, 1), Error);
  // /dev/full accepts being opened and reports a full disk at the first write.
  try {
    BodiesCsv csv("/dev/full", {"rod"}, 1);
    ADD_FAILURE() << "a full disk was not noticed";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("/dev/full: No space left on device"),
              std::string::npos)
        << error.what();
  }
}

TEST(MbsAccepted, EveryCheckpointIsHandedOverOnce) {
  Params params = params_with_step(kMillisecond);
  params.bodies = {body_at("body", 1.0, Eigen::Vector3d::Zero())};
  RigidWorld world(params);
  std::vector<SimTime> times;
  world.on_accepted_state([&times](const State& state) { times.push_back(state.time); });
  world.initialize({});
  for (int i = 0; i < 2; ++i) {
    world.checkpoint();
    run(world, kMillisecond, 1);
    world.rollback();
    run(world, kMillisecond, 1);
  }
  world.checkpoint();
  EXPECT_EQ(times, (std::vector<SimTime>{SimTime{}, kMillisecond, 2 * kMillisecond}));
}

}  // namespace
}  // namespace tandem::mbs::testing
