#pragma once

#include <filesystem>
#include <string>

#include "tests/support/tandem_process.h"

namespace tandem::test {

/// How the bodies of two_worlds() are written down: in two worlds, or all in one.
enum class Written { AsTwoWorlds, AsOneWorld };

/// The scenario of two worlds joined by one flexible link, or by two, in a folder of the test:
///   near: a crank on a hinge of the ground, a bob that hangs on it; with two links also an anvil
///         on a hinge of the ground, where the second link ends,
///   far:  a block between the links (at the end of the one) with a bob and a spring to the ground.
/// Released horizontal; it swings about y. `near` has the ports root1 and, of two links, tip2;
/// `far` has tip1 and root2: each link has an end in either world.
inline std::filesystem::path two_worlds(int links, const TemporaryFolder& folder,
                                        Written written = Written::AsTwoWorlds) {
  const auto body = [](const std::string& name, const std::string& mass_kg, const std::string& at) {
    return "      - {name: " + name + ", mass_kg: " + mass_kg +
           ", inertia_kg_m2: [2.0e-4, 3.0e-4, 4.0e-4], position_m: [" + at + "]}\n";
  };
  const auto hinge = [](const std::string& name, const std::string& ends, const std::string& at) {
    return "      - {name: " + name + ", kind: hinge, " + ends + ", anchor_m: [" + at +
           "], axis: [0, 1, 0]}\n";
  };
  std::string near_bodies = body("crank", "0.2", "0, 0, 0") + body("bob1", "0.1", "0, 0, -0.1");
  std::string near_joints = hinge("pin", "body1: crank", "0, 0, 0") +
                            hinge("bob1_pin", "body1: bob1, body2: crank", "0, 0, 0");
  if (links > 1) {
    near_bodies += body("anvil", "0.3", "0.6, 0, 0");
    near_joints += hinge("anvil_pin", "body1: anvil", "0.6, 0, 0.05");
  }
  const std::string far_bodies =
      body("block", "0.25", "0.3, 0, 0") + body("bob2", "0.1", "0.4, 0, 0");
  const std::string far_joints = hinge("bob2_pin", "body1: bob2, body2: block", "0.3, 0, 0");
  const std::string springs =
      "    springs:\n"
      "      - {name: tether, body1: block, point1_m: [0.3, 0, 0], point2_m: [0.3, 0, 0.4],\n"
      "         stiffness_N_per_m: 20, damping_N_s_per_m: 0.1}\n";
  const auto world = [](const std::string& name, const std::string& bodies,
                        const std::string& joints) {
    return "  - name: " + name + "\n    bodies:\n" + bodies + "    joints:\n" + joints;
  };

  std::string text = "name: two_worlds\nrun: {duration_s: 0.06, macro_step_s: 0.001}\nports:\n";
  for (int link = 1; link <= links; ++link) {
    const std::string n = std::to_string(link);
    const std::string ends[] = {link == 1 ? "crank" : "block", link == 1 ? "block" : "anvil"};
    text += "  - {name: root" + n + ", body: " + ends[0] + ", flexible: link" + n +
            ", node_set: left}\n  - {name: tip" + n + ", body: " + ends[1] + ", flexible: link" +
            n + ", node_set: right}\n";
  }
  text += "mbs:\n";
  if (written == Written::AsTwoWorlds) {
    text +=
        world("near", near_bodies, near_joints) + world("far", far_bodies, far_joints) + springs;
  } else {
    text += world("all", near_bodies + far_bodies, near_joints + far_joints) + springs;
  }
  text += "fem:\n";
  for (int link = 1; link <= links; ++link) {
    text += "  - name: link" + std::to_string(link) + "\n    mesh: {file: " + kExamples +
            "slider_crank/rod.msh, length_scale_m: 0.6, position_m: [" +
            (link == 1 ? "0.15" : "0.45") +
            ", 0, 0]}\n"
            "    material: {young_Pa: 5.0e+7, poisson: 0.3, density_kg_per_m3: 1100}\n"
            "    gravity_m_per_s2: [0, 0, -9.81]\n";
  }
  const std::string file = written == Written::AsTwoWorlds ? "two_worlds.yaml" : "one_world.yaml";
  write_file(folder / file, text);
  return folder / file;
}

}  // namespace tandem::test
