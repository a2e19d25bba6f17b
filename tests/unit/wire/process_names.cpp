// Numbers and names of a run's processes: of one world and one flexible body, and of several.
#include "protocol/wire/process_names.h"

#include <gtest/gtest.h>

namespace tandem::wire {
namespace {

TEST(WireProcesses, OneOfAKindKeepsItsNumberAndName) {
  const ProcessNames names;
  EXPECT_EQ(world_process(0, 1), Process::Mbs);
  EXPECT_EQ(body_process(0, 1), Process::Fem);
  EXPECT_EQ(names.name(Process::Mbs), "mbs");
  EXPECT_EQ(names.program(Process::Fem), "tandem-fem");
  EXPECT_EQ(names.processes(), kFirstBody);
}

TEST(WireProcesses, SeveralHaveNumbersOfTheirOwn) {
  const ProcessNames names({"rod", "arm"}, {"near", "far"});
  const Process arm = body_process(1, 2), far = world_process(1, 2);
  EXPECT_NE(arm, far);
  EXPECT_TRUE(is_flexible(arm));
  EXPECT_FALSE(is_multibody(arm));
  EXPECT_TRUE(is_multibody(far));
  EXPECT_FALSE(is_flexible(far));
  EXPECT_EQ(names.program(arm), "tandem-fem arm");
  EXPECT_EQ(names.program(far), "tandem-mbs far");
  EXPECT_EQ(names.name(world_process(0, 2)), "near");
  EXPECT_EQ(text_of(arm), "fem2");
  EXPECT_EQ(text_of(far), "mbs2");
  EXPECT_LT(static_cast<std::size_t>(far), names.processes());
  EXPECT_EQ(names.processes(), kFirstWorld + 2);
}

// As many as there may be: neither kind's last one is the other's.
TEST(WireProcesses, NumbersOfTheLastOnesDiffer) {
  const Process body = body_process(kMostBodies - 1, kMostBodies);
  const Process world = world_process(kMostWorlds - 1, kMostWorlds);
  EXPECT_TRUE(is_flexible(body));
  EXPECT_TRUE(is_multibody(world));
  EXPECT_LT(static_cast<std::size_t>(world), kProcesses);
}

}  // namespace
}  // namespace tandem::wire
