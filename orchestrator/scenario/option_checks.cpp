#include "orchestrator/scenario/option_checks.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>

namespace tandem::orchestrator {
namespace {

/// The number that the whole text says, or nothing. Space in front is that behind a list's comma.
template <class Number>
std::optional<Number> number_in(const std::string& text) {
  Number number{};
  const char* end = text.data() + text.size();
  const char* begin = text.data() + std::min(text.find_first_not_of(' '), text.size());
  if (begin != end && *begin == '+') ++begin;
  const auto [rest, error] = std::from_chars(begin, end, number);
  if (error != std::errc{} || rest != end) return std::nullopt;
  return number;
}

/// `what`: "a number above 0"; `good` says which finite numbers pass.
template <class Number, class Claim>
CLI::Validator check_of(const std::string& what, const std::string& in_help, Claim good) {
  const auto refusal = [what, good](const std::string& text) -> std::string {
    const std::optional<Number> number = number_in<Number>(text);
    if (number && std::isfinite(static_cast<double>(*number)) && good(*number)) return {};
    return fmt::format("'{}' is not {}.", text, what);
  };
  return {refusal, in_help};
}

}  // namespace

CLI::Validator number_above_zero() {
  return check_of<double>("a number above 0", "> 0", [](double x) { return x > 0.0; });
}

CLI::Validator number_from_zero() {
  return check_of<double>("a number of at least 0", ">= 0", [](double x) { return x >= 0.0; });
}

CLI::Validator number_between(double low, double high) {
  const std::string range = fmt::format("{:g} to {:g}", low, high);
  return check_of<double>("a number from " + range, range,
                          [low, high](double x) { return x >= low && x <= high; });
}

CLI::Validator whole_number_between(std::int64_t low, std::int64_t high) {
  const std::string range = fmt::format("{} to {}", low, high);
  return check_of<std::int64_t>("a whole number from " + range, range,
                                [low, high](std::int64_t n) { return n >= low && n <= high; });
}

}  // namespace tandem::orchestrator
