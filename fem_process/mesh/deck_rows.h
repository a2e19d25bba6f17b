#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "fem_process/mesh/deck.h"
#include "fem_process/mesh/deck_keywords.h"
#include "fem_process/mesh/deck_lexer.h"
#include "fem_process/mesh/deck_notes.h"

namespace tandem::fem {

/// The value of a keyword's parameter (by deck_key()); null without it.
[[nodiscard]] const std::string* parameter(const DeckLine& line, std::string_view key);
/// That value, or a Usage error where it is missing or empty.
[[nodiscard]] std::string needed(const DeckLexer& in, const DeckLine& line, std::string_view key);
/// Refuses a keyword with other parameters than these: they would change what its rows mean.
void allow(const DeckLexer& in, const DeckLine& line, std::initializer_list<std::string_view> keys);
/// `most` numbers of a row; what is left out is zero.
[[nodiscard]] std::vector<double> reals(const DeckLexer& in, const DeckLine& line,
                                        std::size_t most);
/// Goes on with the file of *NODE or *ELEMENT, INPUT=.
void include_input(DeckLexer& in, const DeckLine& line);

/// Rows of *NODE, *ELEMENT, *NSET, *ELSET, *SURFACE and *SYSTEM, which it puts into a scope.
class DeckRows {
 public:
  DeckRows(DeckLexer& in, const Deck& deck, DeckNotes& notes)
      : in_(in), deck_(deck), notes_(notes) {}

  /// A keyword line of these kinds; rows up to the next one belong to it.
  void begin(DeckKeyword kind, const DeckLine& line, DeckScope& scope);
  void row(const DeckLine& line);
  /// Refuses an element whose rows have ended too early.
  void finish();
  /// Coordinates are global again.
  void reset_system() { system_.setIdentity(); }

 private:
  void begin_node(const DeckLine& line);
  void begin_element(const DeckLine& line);
  void begin_set(const DeckLine& line, bool of_nodes);
  void begin_surface(const DeckLine& line);

  void node(const DeckLine& line);
  void element(const DeckLine& line);
  void add_element();
  void members(const DeckLine& line);
  void generate(const DeckLine& line);
  void name_in_set(const DeckLine& line, const std::string& name);
  void surface(const DeckLine& line);
  void system(const DeckLine& line);

  [[nodiscard]] std::string row_is() const;
  [[nodiscard]] std::int64_t whole(const DeckLine& line, std::string_view field,
                                   const char* what) const;

  DeckLexer& in_;
  const Deck& deck_;
  DeckNotes& notes_;
  DeckScope* scope_ = nullptr;
  DeckKeyword kind_ = DeckKeyword::Node;
  DeckScope::Set* set_ = nullptr;  ///< into which the rows go as well, or alone
  DeckScope::Surface* surface_ = nullptr;
  std::string instance_;  ///< of INSTANCE=, by its key
  bool generate_ = false;
  bool cylindrical_ = false;
  std::string type_;  ///< of the elements
  DeckElementType element_type_;
  std::vector<std::int64_t> pending_;
  int pending_line_ = 0;
  Eigen::Isometry3d system_ = Eigen::Isometry3d::Identity();
  int system_rows_ = 0;
  Eigen::Vector3d system_origin_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d system_x_ = Eigen::Vector3d::UnitX();
};

}  // namespace tandem::fem
