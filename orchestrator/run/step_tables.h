#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "orchestrator/files/text_file.h"
#include "orchestrator/run/energy_table.h"
#include "protocol/wire/journal.h"

namespace tandem::orchestrator {

/// steps.csv (one row per macro step: outcome and ledger), ports.csv (accepted motions and
/// wrenches) and energy.csv where energies were observed; units in the headers, numbers in the
/// shortest form that reads back to the same bits.
class StepTables {
 public:
  /// `parts`: see EnergyTable.
  StepTables(const std::filesystem::path& directory, const std::vector<std::string>& ports,
             std::vector<std::string> parts);

  /// Appends the rows of one macro step; macro step 0 has a row in ports.csv alone.
  void write(const wire::StepJournal& journal);
  void flush();

 private:
  TextFile steps_;
  TextFile ports_;
  EnergyTable energy_;
};

/// The accepted motions and wrenches at the end of a macro step; empty when the step was not
/// accepted.
struct AcceptedInterface {
  SimTime time{};
  MotionSet motions;
  WrenchSet wrenches;
};
[[nodiscard]] AcceptedInterface accepted_interface(const wire::StepJournal& journal);

/// "t_s,<port>.p_x_m,…\n" and one row below it; components without a value stay empty.
[[nodiscard]] std::string interface_header(const std::vector<std::string>& ports);
[[nodiscard]] std::string interface_row(const AcceptedInterface& interface);

}  // namespace tandem::orchestrator
