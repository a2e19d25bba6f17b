#include "orchestrator/files/displacement_text.h"

#include <fmt/format.h>

namespace tandem::orchestrator {

std::string displacement_text(const std::string& what, const std::string& key,
                              const nlohmann::ordered_json& by_name) {
  if (by_name.empty()) return fmt::format("no {} is asked for ({})", what, key);
  std::string text = what;
  for (const auto& [name, u] : by_name.items()) {
    text += fmt::format("{} of '{}' ({:.6g}, {:.6g}, {:.6g}) m", text == what ? "" : ",", name,
                        u.at(0).get<double>(), u.at(1).get<double>(), u.at(2).get<double>());
  }
  return text;
}

}  // namespace tandem::orchestrator
