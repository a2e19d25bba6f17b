#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "protocol/contract/subsystem.h"

namespace tandem {

/// A command to the flexible side of a run that goes on; see Subsystem::command().
struct Command {
  std::int64_t number = 0;  ///< the source's own
  std::string text;
};

/// Where commands come from. The driver asks before every macro step.
class CommandSource {
 public:
  virtual ~CommandSource() = default;
  /// The commands that wait, in the order in which they are to be made.
  [[nodiscard]] virtual std::vector<Command> take() = 0;
  /// How one went; `macro_step` is the first that it acts on.
  virtual void answer(const Command& command, std::int64_t macro_step,
                      const CommandResult& result) = 0;
};

}  // namespace tandem
