#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <string>
#include <vector>

#include "tests/support/tandem_process.h"

// demo.sh, test.sh and what they share, on machines that are played by programs of a folder of
// their own: that folder alone is the PATH. What a real Debian makes of it, .ci/fresh-debian
// checks.
namespace tandem::test {
namespace {

namespace fs = std::filesystem;

const std::string kSource = TANDEM_SOURCE_DIR "/";

bool has(const std::string& text, const std::string& words) {
  return text.find(words) != std::string::npos;
}

// `dpkg-query -W -f=FORMAT PACKAGE` of a database of lines "PACKAGE ARCHITECTURE STATE"; "-" is an
// architecture that is not known, as of a package that another one mentions.
const char* const kDpkgQuery = R"(#!/bin/bash
[[ $1 == -W && $2 == -f=* && $# -eq 3 ]] || exit 2
found=1
while read -r package architecture state; do
  [[ $package == "$3" ]] || continue
  found=0
  line=${2#-f=}
  line=${line//'${db:Status-Status}'/$state}
  printf '%b' "${line//'${Architecture}'/${architecture#-}}"
done <"${0%/*}/states"
[[ $found == 0 ]] || echo "dpkg-query: no packages found matching $3" >&2
exit $found
)";

// Programs that note how they were called.
const char* const kAptGet = R"(#!/bin/bash
echo "apt-get $*" >>"${0%/*}/calls"
[[ " $* " != *" ${APT_FAILS_AT-nothing} "* ]] || { echo "E: no such archive" >&2; exit 100; }
)";
const char* const kSudo = R"(#!/bin/bash
echo sudo >>"${0%/*}/calls"
exec "$@"
)";

/// A machine with bash and the programs that are put there.
class Machine {
 public:
  Machine() : folder_("tandem_machine") {
    for (const char* program : {"bash", "sh", "env"}) {
      const std::string name = program;
      const fs::path there = fs::exists("/bin/" + name) ? "/bin/" + name : "/usr/bin/" + name;
      fs::create_symlink(there, folder_ / name);
    }
  }
  void put(const std::string& program, const std::string& script) const {
    write_file(folder_ / program, script);
    fs::permissions(folder_ / program, fs::perms::owner_all);
  }
  /// A Debian of amd64 whose dpkg knows these packages; the user is root.
  void put_debian(const std::string& states) const {
    write_file(folder_ / "states", states);
    put("dpkg-query", kDpkgQuery);
    put("dpkg", "#!/bin/bash\necho amd64\n");
    put("apt-get", kAptGet);
    put("id", "#!/bin/bash\necho 0\n");
  }
  /// A function of a script of .ci with its arguments, under the options of demo.sh and test.sh.
  [[nodiscard]] Ended call(const std::string& script, const std::vector<std::string>& words,
                           Environment environment = {}) const {
    std::vector<std::string> command{"/bin/bash", "-c", R"(set -euo pipefail; source "$0"; "$@")",
                                     kSource + ".ci/" + script};
    command.insert(command.end(), words.begin(), words.end());
    environment["PATH"] = folder_.path().string();
    return run_command(command, environment);
  }
  [[nodiscard]] Ended install(std::vector<std::string> packages,
                              const Environment& environment = {}) const {
    packages.insert(packages.begin(), "install_missing");
    return call("install.sh", packages, environment);
  }
  /// What was called, one line each.
  [[nodiscard]] std::string calls() const { return read_file(folder_ / "calls"); }

 private:
  TemporaryFolder folder_;
};

struct Known {
  std::string name;
  std::string states;  // of package "wanted"
  bool there = false;
};
void PrintTo(const Known& known, std::ostream* out) { *out << known.name; }

class WantedPackage : public testing::TestWithParam<Known> {};

TEST_P(WantedPackage, IsInstalledUnlessItIsThere) {
  const Machine machine;
  machine.put_debian("before amd64 installed\n" + GetParam().states + "after all installed\n");
  const Ended ended = machine.install({"before", "wanted", "after"});
  EXPECT_EQ(ended.code, 0) << ended.output;
  if (GetParam().there) {
    EXPECT_EQ(ended.output, "");
    EXPECT_EQ(machine.calls(), "");
  } else {
    EXPECT_EQ(ended.output, "Installing 1 packages: wanted\n");
    EXPECT_TRUE(has(machine.calls(), " update\n")) << machine.calls();
    EXPECT_TRUE(has(machine.calls(), " install -y --no-install-recommends wanted\n"))
        << machine.calls();
  }
}

// The states of dpkg-query(1), all eight, and a package of which dpkg has never heard.
INSTANTIATE_TEST_SUITE_P(
    State, WantedPackage,
    testing::Values(Known{"unknown", "", false},
                    Known{"mentioned", "wanted - not-installed\n", false},
                    Known{"not_installed", "wanted amd64 not-installed\n", false},
                    Known{"config_files", "wanted amd64 config-files\n", false},
                    Known{"half_installed", "wanted amd64 half-installed\n", false},
                    Known{"unpacked", "wanted amd64 unpacked\n", false},
                    Known{"half_configured", "wanted amd64 half-configured\n", false},
                    Known{"triggers_awaited", "wanted amd64 triggers-awaited\n", true},
                    Known{"triggers_pending", "wanted amd64 triggers-pending\n", true},
                    Known{"installed", "wanted amd64 installed\n", true}),
    [](const auto& test) { return test.param.name; });

// dpkg knows a package once per architecture; that of the machine is needed, or "all".
INSTANTIATE_TEST_SUITE_P(
    Architecture, WantedPackage,
    testing::Values(
        Known{"all", "wanted all installed\n", true},
        Known{"foreign_alone", "wanted i386 installed\n", false},
        Known{"foreign_removed", "wanted amd64 installed\nwanted i386 config-files\n", true},
        Known{"foreign_mentioned", "wanted i386 not-installed\nwanted amd64 installed\n", true},
        Known{"own_removed", "wanted amd64 config-files\nwanted i386 installed\n", false},
        Known{"own_broken", "wanted i386 installed\nwanted amd64 half-configured\n", false},
        Known{"both", "wanted amd64 installed\nwanted i386 installed\n", true},
        Known{"none", "wanted amd64 not-installed\nwanted i386 not-installed\n", false}),
    [](const auto& test) { return test.param.name; });

TEST(InstallMissing, OldPackageListsServeWhereUpdateFails) {
  const Machine machine;
  machine.put_debian("");
  const Ended ended = machine.install({"wanted"}, {{"APT_FAILS_AT", "update"}});
  EXPECT_EQ(ended.code, 0) << ended.output;
  EXPECT_TRUE(has(ended.output, "apt-get update failed: going on")) << ended.output;
  EXPECT_TRUE(has(machine.calls(), "install -y --no-install-recommends wanted"));
}

TEST(InstallMissing, AFailedInstallationEndsTheScriptAndNamesThePackages) {
  const Machine machine;
  machine.put_debian("there amd64 installed\n");
  const Ended ended = machine.install({"wanted", "there", "too"}, {{"APT_FAILS_AT", "install"}});
  EXPECT_EQ(ended.code, 1) << ended.output;
  EXPECT_TRUE(has(ended.output, "E: no such archive\n")) << ended.output;
  EXPECT_TRUE(has(ended.output, "apt-get install --no-install-recommends wanted too\n"))
      << ended.output;
}

TEST(InstallMissing, SudoServesWhoIsNotRoot) {
  const Machine machine;
  machine.put_debian("");
  machine.put("id", "#!/bin/bash\necho 1000\n");
  machine.put("sudo", kSudo);
  const Ended ended = machine.install({"wanted"});
  EXPECT_EQ(ended.code, 0) << ended.output;
  EXPECT_TRUE(has(machine.calls(), "sudo\napt-get")) << machine.calls();
}

TEST(InstallMissing, WithoutRootAndSudoTheCommandIsNamed) {
  const Machine machine;
  machine.put_debian("there amd64 installed\n");
  machine.put("id", "#!/bin/bash\necho 1000\n");
  const Ended ended = machine.install({"wanted", "there"});
  EXPECT_EQ(ended.code, 1) << ended.output;
  EXPECT_TRUE(has(ended.output, "neither root nor sudo")) << ended.output;
  EXPECT_TRUE(has(ended.output, "apt-get install --no-install-recommends wanted\n"))
      << ended.output;
  EXPECT_EQ(machine.calls(), "");
  // Nobody needs to be anybody where nothing is missing.
  EXPECT_EQ(machine.install({"there"}).code, 0);
}

TEST(InstallMissing, WithoutDpkgOrAptThePackagesAreNamedAndTheScriptGoesOn) {
  for (const char* lacking : {"both", "dpkg-query", "apt-get"}) {
    const Machine machine;
    if (std::string(lacking) == "dpkg-query") machine.put("apt-get", kAptGet);
    if (std::string(lacking) == "apt-get") machine.put("dpkg-query", kDpkgQuery);
    const Ended ended = machine.install({"wanted", "too"});
    EXPECT_EQ(ended.code, 0) << lacking << ended.output;
    EXPECT_TRUE(has(ended.output, "not a Debian system")) << lacking << ended.output;
    EXPECT_TRUE(has(ended.output, "  wanted too\n")) << lacking << ended.output;
    EXPECT_EQ(machine.calls(), "");
  }
}

// `ip` of a machine without network namespaces, with or without a route for multicast.
std::string ip_that_exits_with(int code) { return "#!/bin/bash\nexit " + std::to_string(code); }

TEST(OnLoopback, UsesTheMachinesNetworkWhereNoNamespaceIsAllowed) {
  const Machine machine;
  machine.put("unshare", "#!/bin/bash\nexit 1\n");
  machine.put("ip", ip_that_exits_with(0));
  const Ended ended = machine.call("network.sh", {"on_loopback", "bash", "-c", "echo ran; exit 7"});
  EXPECT_EQ(ended.code, 7);
  EXPECT_TRUE(has(ended.output, "using the machine's own network")) << ended.output;
  EXPECT_TRUE(has(ended.output, "ran\n")) << ended.output;
}

TEST(OnLoopback, NamesTheRemedyWhereThereIsNoRouteEither) {
  const Machine machine;
  machine.put("unshare", "#!/bin/bash\nexit 1\n");
  machine.put("ip", ip_that_exits_with(2));
  const Ended ended = machine.call("network.sh", {"on_loopback", "bash", "-c", "echo ran"});
  EXPECT_EQ(ended.code, 4) << ended.output;
  EXPECT_TRUE(has(ended.output, "ip route add 224.0.0.0/4 dev lo")) << ended.output;
  EXPECT_FALSE(has(ended.output, "ran\n")) << ended.output;
}

// Without `ip` nobody knows of a route; the command itself says when there is none.
TEST(OnLoopback, RunsTheCommandWithoutUnshareAndIp) {
  const Machine machine;
  const Ended ended = machine.call("network.sh", {"on_loopback", "bash", "-c", "echo ran"});
  EXPECT_EQ(ended.code, 0) << ended.output;
  EXPECT_TRUE(has(ended.output, "ran\n")) << ended.output;
}

class Script : public testing::TestWithParam<std::string> {};

TEST_P(Script, HelpAndReadmeNameTheSameOptions) {
  const Ended help = run_command({kSource + GetParam(), "--help"});
  EXPECT_EQ(help.code, 0);
  EXPECT_TRUE(has(help.output, "./" + GetParam() + " --configure-only")) << help.output;
  const std::string readme = read_file(kSource + "README.md");
  const std::regex option("--[a-z-]+");
  for (std::sregex_iterator it(help.output.begin(), help.output.end(), option), end; it != end;
       ++it) {
    const std::string command = "./" + GetParam() + "[^\n]* " + it->str();
    EXPECT_TRUE(std::regex_search(readme, std::regex(command))) << it->str();
  }
}

TEST_P(Script, RefusesAnUnknownOptionAndNamesTheOthers) {
  const Ended ended = run_command({kSource + GetParam(), "--configure-only", "--nonsense"});
  EXPECT_EQ(ended.code, 2) << ended.output;
  EXPECT_TRUE(has(ended.output, GetParam() + ": unknown option '--nonsense'")) << ended.output;
  EXPECT_TRUE(has(ended.output, "--configure-only")) << ended.output;
}

INSTANTIATE_TEST_SUITE_P(Root, Script, testing::Values("demo.sh", "test.sh"),
                         [](const auto& test) { return test.param.substr(0, 4); });

TEST(DemoScript, RefusesAScenarioThatIsNotThereBeforeItBuilds) {
  const Ended ended = run_command({kSource + "demo.sh", "no folder/scenario.yaml"});
  EXPECT_EQ(ended.code, 2) << ended.output;
  EXPECT_TRUE(has(ended.output, "there is no scenario 'no folder/scenario.yaml'")) << ended.output;
}

}  // namespace
}  // namespace tandem::test
