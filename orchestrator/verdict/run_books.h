#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "orchestrator/scenario/model.h"
#include "orchestrator/verdict/verdict.h"
#include "protocol/contract/subsystem.h"
#include "protocol/driver/energy_range.h"

namespace tandem::orchestrator {

/// Whether the flexible side's integrator is of second order.
[[nodiscard]] bool is_second_order(const scenario::Node& fem);

/// What decides on the remedies: scheme, integrators, contact. `monolithic`: no scheme is used.
[[nodiscard]] RunBooks books_of_model(const Model& model, bool monolithic);

/// The books of a finished coupled run: its summary, and bodies.csv in `folder` for the bodies that
/// carry no port.
[[nodiscard]] RunBooks books_of_run(const Model& model, bool monolithic,
                                    const nlohmann::ordered_json& summary,
                                    const std::filesystem::path& folder);

/// The books of the flexible side alone, which is looked into now and then; what moves its ports
/// does work from outside.
class BooksOfOneSide {
 public:
  BooksOfOneSide(FemSide& side, std::int64_t steps);
  /// After the step of that number, from 1.
  void look(std::int64_t step);
  /// At the end: the energies of `books`.
  void add_to(RunBooks& books);

 private:
  EnergyBook book();

  FemSide& side_;
  std::int64_t every_;
  EnergyBook begin_;
  EnergyRange range_;
};

}  // namespace tandem::orchestrator
