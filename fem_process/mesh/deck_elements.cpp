#include "fem_process/mesh/deck_elements.h"

namespace tandem::fem {
namespace {

struct Family {
  std::string_view begin;     ///< of the type's name, up to the number of nodes
  std::string_view suffixes;  ///< letters that may follow
  DeckElementType type;
};

constexpr std::string_view kAny = "*";

// Of several that fit, the first. Numbers are followed by letters alone: C3D10 is not C3D1.
constexpr Family kFamilies[] = {{"C3D4", "HPRTE", {DeckShape::Tetrahedron, 4}},
                                {"C3D10", "HIMPSTEF", {DeckShape::Tetrahedron, 10}},
                                {"DC3D4", "E", {DeckShape::Tetrahedron, 4}},
                                {"DC3D10", "E", {DeckShape::Tetrahedron, 10}},
                                {"C3D20", kAny, {DeckShape::Solid, 20}},
                                {"C3D27", kAny, {DeckShape::Solid, 27}},
                                {"C3D15", kAny, {DeckShape::Solid, 15}},
                                {"C3D13", kAny, {DeckShape::Solid, 13}},
                                {"C3D8", kAny, {DeckShape::Solid, 8}},
                                {"C3D6", kAny, {DeckShape::Solid, 6}},
                                {"C3D5", kAny, {DeckShape::Solid, 5}},
                                {"DC3D20", kAny, {DeckShape::Solid, 20}},
                                {"DC3D15", kAny, {DeckShape::Solid, 15}},
                                {"DC3D8", kAny, {DeckShape::Solid, 8}},
                                {"DC3D6", kAny, {DeckShape::Solid, 6}},
                                {"DC3D5", kAny, {DeckShape::Solid, 5}},
                                {"SC8", kAny, {DeckShape::Solid, 8}},
                                {"SC6", kAny, {DeckShape::Solid, 6}},
                                {"CSS8", kAny, {DeckShape::Solid, 8}},
                                {"CIN3D8", kAny, {DeckShape::Solid, 8}},
                                {"STRI3", "", {DeckShape::Triangle, 3}},
                                {"STRI65", "", {DeckShape::Triangle, 6}},
                                {"S3", "RST", {DeckShape::Triangle, 3}},
                                {"S6", "", {DeckShape::Triangle, 6}},
                                {"DS3", "", {DeckShape::Triangle, 3}},
                                {"DS6", "", {DeckShape::Triangle, 6}},
                                {"CPS3", "TE", {DeckShape::Triangle, 3}},
                                {"CPS6", "MTE", {DeckShape::Triangle, 6}},
                                {"CPE3", "HTE", {DeckShape::Triangle, 3}},
                                {"CPE6", "HMTE", {DeckShape::Triangle, 6}},
                                {"CPEG3", "HT", {DeckShape::Triangle, 3}},
                                {"CPEG6", "HMT", {DeckShape::Triangle, 6}},
                                {"CAX3", "HTE", {DeckShape::Triangle, 3}},
                                {"CAX6", "HMTE", {DeckShape::Triangle, 6}},
                                {"DC2D3", "E", {DeckShape::Triangle, 3}},
                                {"DC2D6", "E", {DeckShape::Triangle, 6}},
                                {"DCAX3", "E", {DeckShape::Triangle, 3}},
                                {"DCAX6", "E", {DeckShape::Triangle, 6}},
                                {"AC2D3", "", {DeckShape::Triangle, 3}},
                                {"AC2D6", "", {DeckShape::Triangle, 6}},
                                {"M3D3", "T", {DeckShape::Triangle, 3}},
                                {"M3D6", "", {DeckShape::Triangle, 6}},
                                {"SFM3D3", "", {DeckShape::Triangle, 3}},
                                {"SFM3D6", "", {DeckShape::Triangle, 6}},
                                {"R3D3", "", {DeckShape::Triangle, 3}},
                                {"F3D3", "", {DeckShape::Triangle, 3}},
                                {"B21", "H", {DeckShape::Line, 2}},
                                {"B22", "H", {DeckShape::Line, 3}},
                                {"B23", "H", {DeckShape::Line, 2}},
                                {"B31", "HOSR", {DeckShape::Line, 2}},
                                {"B32", "HOSR", {DeckShape::Line, 3}},
                                {"B33", "H", {DeckShape::Line, 2}},
                                {"T2D2", kAny, {DeckShape::Line, 2}},
                                {"T2D3", kAny, {DeckShape::Line, 3}},
                                {"T3D2", kAny, {DeckShape::Line, 2}},
                                {"T3D3", kAny, {DeckShape::Line, 3}},
                                {"PIPE31", kAny, {DeckShape::Line, 2}},
                                {"PIPE32", kAny, {DeckShape::Line, 3}},
                                {"R2D2", "", {DeckShape::Line, 2}},
                                {"RB3D2", "", {DeckShape::Line, 2}},
                                {"S4", kAny, {DeckShape::Other, 4}},
                                {"S8", kAny, {DeckShape::Other, 8}},
                                {"S9", kAny, {DeckShape::Other, 9}},
                                {"CPS4", kAny, {DeckShape::Other, 4}},
                                {"CPS8", kAny, {DeckShape::Other, 8}},
                                {"CPE4", kAny, {DeckShape::Other, 4}},
                                {"CPE8", kAny, {DeckShape::Other, 8}},
                                {"CAX4", kAny, {DeckShape::Other, 4}},
                                {"CAX8", kAny, {DeckShape::Other, 8}},
                                {"M3D4", kAny, {DeckShape::Other, 4}},
                                {"M3D8", kAny, {DeckShape::Other, 8}},
                                {"M3D9", kAny, {DeckShape::Other, 9}},
                                {"R3D4", "", {DeckShape::Other, 4}},
                                {"SFM3D4", kAny, {DeckShape::Other, 4}},
                                {"SFM3D8", kAny, {DeckShape::Other, 8}},
                                {"COH3D6", kAny, {DeckShape::Other, 6}},
                                {"COH3D8", kAny, {DeckShape::Other, 8}}};

bool fits(std::string_view type, const Family& family) {
  if (type.substr(0, family.begin.size()) != family.begin) return false;
  const std::string_view rest = type.substr(family.begin.size());
  if (family.suffixes == kAny) return rest.empty() || rest[0] < '0' || rest[0] > '9';
  return rest.find_first_not_of(family.suffixes) == std::string_view::npos;
}

}  // namespace

DeckElementType deck_element_type(std::string_view type) {
  for (const Family& family : kFamilies) {
    if (fits(type, family)) return family.type;
  }
  // Kinds of solids that are not listed: acoustic, fluid, piezoelectric, infinite …
  for (std::string_view solid : {"C3D", "AC3D", "DC3D", "DCC3D", "Q3D", "F3D", "FC3D", "EC3D",
                                 "CIN3D", "CCL", "PC3D", "GK3D", "EMC3D"}) {
    if (type.substr(0, solid.size()) == solid) return {DeckShape::Solid, 0};
  }
  return {};
}

}  // namespace tandem::fem
