#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace tandem::orchestrator {

/// Displacements by name, as a person reads them: "mean displacement of 'tip' (0.0012, 0, -3e-05)
/// m, of 'eye' (…) m". `what` is "mean displacement"; `key` says where names come from, for when
/// there is none.
[[nodiscard]] std::string displacement_text(const std::string& what, const std::string& key,
                                            const nlohmann::ordered_json& by_name);

}  // namespace tandem::orchestrator
