// Damaged mesh files: read, or refused with exit code 2, within bounded time and memory.
#include <gtest/gtest.h>

#include <random>

#include "fem_process/mesh/deck_lexer.h"
#include "tests/support/fem_box.h"
#include "tests/support/fem_support.h"

namespace tandem::fem {
namespace {

using namespace testing;

const std::string kDeck =
    "*HEADING\nA deck\n*PART, NAME=P\n*NODE, NSET=all\n1, 0, 0, 0\n2, 1, 0, 0\n3, 0, 1, 0\n"
    "4, 0, 0, 1\n5, 1, 1, 1\n*ELEMENT, TYPE=C3D4, ELSET=BODY\n1, 1, 2, 3, 4\n2, 2, 5, 3, 4\n"
    "*ELEMENT, TYPE=CPS3, ELSET=skin\n7, 1, 3, 2\n*ELEMENT, TYPE=GAPUNI\n9, 1, 2\n"
    "*NSET, NSET=some, GENERATE\n1, 5, 2\n*NSET, NSET=more, ELSET=BODY\nsome, 4\n"
    "*ELSET, ELSET=two\nBODY, 7\n*SURFACE, NAME=S, TYPE=ELEMENT\ntwo, S1\n1\n*END PART\n"
    "*ASSEMBLY, NAME=A\n*INSTANCE, NAME=P-1, PART=P\n*END INSTANCE\n*INSTANCE, NAME=P-2, PART=P\n"
    "1., 0., 0.\n0, 0, 0, 0, 0, 1, 90.\n*END INSTANCE\n*SYSTEM\n1, 0, 0, 1, 1, 0\n0, 0, 0\n"
    "*NODE, SYSTEM=C\n1, 1, 45, 2\n*NSET, NSET=picked, INSTANCE=P-2\n1, some\n"
    "*NSET, NSET=both\nP-1.some, P-2.3\n*END ASSEMBLY\n*MATERIAL, NAME=M\n*ELASTIC\n1., 0.3\n"
    "*STEP\n*END STEP\n";

/// A version 2.2 and a 4.1 mesh of one tetrahedron.
const std::string kOld =
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 8 \"solid\"\n$EndPhysicalNames\n"
    "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n"
    "$Elements\n2\n1 2 2 7 1 1 3 2\n2 4 2 8 1 1 2 3 4\n$EndElements\n";
const std::string kNew =
    "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 1 1\n5 0 0 0 1 1 0 1 7 0\n"
    "6 0 0 0 1 1 1 1 8 1 5\n$EndEntities\n$Nodes\n1 4 1 4\n3 6 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n"
    "0 1 0\n0 0 1\n$EndNodes\n$Elements\n2 2 1 2\n2 5 2 1\n1 1 3 2\n3 6 4 1\n2 1 2 3 4\n"
    "$EndElements\n";

/// One to four bytes, words or lines changed, doubled, deleted, exchanged or cut off.
std::string mutated(std::string text, std::mt19937& random) {
  static const std::string kBytes = "0123456789-+.,*=$\"\n eDSNA\xff";
  static const char* const kWords[] = {"-1",
                                       "9223372036854775807",
                                       "-9223372036854775808",
                                       "4000000000",
                                       "1e308",
                                       "*NSET, NSET=some, GENERATE\n1, 9223372036854775807\n",
                                       "*INCLUDE, INPUT=mutated.inp\n",
                                       "*PART, NAME=P\n",
                                       "*END INSTANCE\n",
                                       ",,,,",
                                       "GENERATE",
                                       "\n*"};
  const auto below = [&](std::size_t n) { return random() % std::max<std::size_t>(n, 1); };
  for (std::size_t change = 0, changes = 1 + below(4); change < changes; ++change) {
    const std::size_t at = below(text.size());
    const std::size_t size = below(24);
    switch (below(6)) {
      case 0:
        if (!text.empty()) text[at] = kBytes[below(kBytes.size())];
        break;
      case 1:
        text.insert(at, text.substr(at, size));
        break;
      case 2:
        text.erase(at, size);
        break;
      case 3:
        text.insert(at, kWords[below(std::size(kWords))]);
        break;
      case 4:
        text.insert(at, text.substr(below(text.size()), below(80)));
        break;
      default:
        if (below(8) == 0) text.resize(at);
    }
  }
  return text;
}

/// Text outside a usage error, or none. Any other exception is a failure.
void expect_read_or_refused(const std::string& name, const std::string& text, int& read) {
  try {
    static_cast<void>(read_mesh({.file = temporary_file(name, text)}));
    ++read;
  } catch (const Error& error) {
    ASSERT_EQ(error.exit_code(), 2) << error.what() << "\n" << text;
    ASSERT_NE(std::string(error.what()).find(':'), std::string::npos) << error.what();
  } catch (const std::exception& error) {
    FAIL() << error.what() << "\n" << text;
  }
}

TEST(FemMeshMutations, AreReadOrRefused) {
  std::mt19937 random(20240817);
  int read = 0;
  for (int round = 0; round < 4000; ++round) {
    expect_read_or_refused("mutated.inp", mutated(kDeck, random), read);
    expect_read_or_refused("mutated_2.msh", mutated(kOld, random), read);
    expect_read_or_refused("mutated_4.msh", mutated(kNew, random), read);
    ASSERT_FALSE(HasFatalFailure()) << round;
  }
  EXPECT_GT(read, 600);  // a twentieth: the mutations are not all fatal
}

// ---- the lexer ---------------------------------------------------------------------------------

TEST(FemDeckLexer, FieldsKeepQuotedCommas) {
  const std::vector<std::string_view> fields = deck_fields(" a ,\"b, c\",, 4 ,,");
  EXPECT_EQ(fields, (std::vector<std::string_view>{"a", "b, c", "", "4"}));
  EXPECT_TRUE(deck_fields(",").empty());
}

TEST(FemDeckLexer, Numbers) {
  double value = 0.0;
  EXPECT_TRUE(deck_real("1.5D+3", value));
  EXPECT_EQ(value, 1500.0);
  EXPECT_TRUE(deck_real("+.5", value));
  EXPECT_EQ(value, 0.5);
  for (const char* text : {"", "abc", "1e999", "nan", "inf", "1,5", "d"}) {
    EXPECT_FALSE(deck_real(text, value)) << text;
  }
}

TEST(FemDeckLexer, KeywordsGoOnAndTheStepEndsTheText) {
  DeckLexer in(temporary_file("lexer.inp",
                              "** a comment\n\n*Solid  Section, elset=\"a, b\",\nMATERIAL = m,\n"
                              "1.,\n*NODE,\n1, 2\n*STEP\n*NODE\n"));
  DeckLine line;
  ASSERT_TRUE(in.next(line));
  EXPECT_EQ(line.keyword, "SOLID SECTION");
  EXPECT_EQ(line.line, 3);
  ASSERT_EQ(line.parameters.size(), 2U);
  EXPECT_EQ(line.parameters[0].value, "a, b");
  EXPECT_EQ(line.parameters[1].key, "MATERIAL");
  EXPECT_EQ(line.parameters[1].value, "m");
  ASSERT_TRUE(in.next(line));
  EXPECT_FALSE(line.is_keyword);
  EXPECT_TRUE(line.goes_on);
  EXPECT_EQ(line.line, 5);
  ASSERT_TRUE(in.next(line));
  EXPECT_EQ(line.keyword, "NODE");
  EXPECT_TRUE(line.parameters.empty());
  ASSERT_TRUE(in.next(line));
  EXPECT_EQ(line.fields.size(), 2U);
  EXPECT_FALSE(in.next(line));
  EXPECT_EQ(in.step_line(), 8);
}

}  // namespace
}  // namespace tandem::fem
