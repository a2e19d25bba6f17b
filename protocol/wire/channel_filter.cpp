#include "protocol/wire/channel_filter.h"

#include <string_view>

namespace tandem::wire {
namespace {

constexpr auto kWord = static_cast<std::uint16_t>(BPF_LD | BPF_W | BPF_ABS);
constexpr auto kHalf = static_cast<std::uint16_t>(BPF_LD | BPF_H | BPF_ABS);
constexpr auto kByte = static_cast<std::uint16_t>(BPF_LD | BPF_B | BPF_ABS);
constexpr auto kEqual = static_cast<std::uint16_t>(BPF_JMP | BPF_JEQ | BPF_K);
constexpr auto kReturn = static_cast<std::uint16_t>(BPF_RET | BPF_K);
constexpr sock_filter kDrop{kReturn, 0, 0, 0};
constexpr sock_filter kPass{kReturn, 0, 0, 0xffffffffU};

// The IP source address is at byte 12 of the network header, the UDP source port at byte 0 of the
// datagram; LCM's magic and number stand behind the 8 bytes of the UDP header, then the channel.
constexpr auto kSourceAddressAt = static_cast<std::uint32_t>(SKF_NET_OFF) + 12U;
constexpr std::uint32_t kChannelAt = 8 + 8;

struct Comparison {
  sock_filter load;
  std::uint32_t value;
};

/// The comparisons that find `text` at `at`, in pieces as large as the machine loads.
std::vector<Comparison> comparisons(std::string_view text, std::uint32_t at) {
  std::vector<Comparison> steps;
  while (!text.empty()) {
    const std::size_t size = text.size() >= 4 ? 4 : text.size() >= 2 ? 2 : 1;
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i) {
      value = (value << 8U) | static_cast<std::uint8_t>(text[i]);
    }
    steps.push_back({{size == 4 ? kWord : size == 2 ? kHalf : kByte, 0, 0, at}, value});
    text.remove_prefix(size);
    at += static_cast<std::uint32_t>(size);
  }
  return steps;
}

/// Goes on behind `then` at the first difference, else through it.
void append_if(std::vector<sock_filter>& program, const std::vector<Comparison>& steps,
               const std::vector<sock_filter>& then) {
  for (std::size_t i = 0; i < steps.size(); ++i) {
    const std::size_t behind = 2 * (steps.size() - i - 1) + then.size();
    program.push_back(steps[i].load);
    program.push_back({kEqual, 0, static_cast<std::uint8_t>(behind), steps[i].value});
  }
  program.insert(program.end(), then.begin(), then.end());
}

}  // namespace

std::vector<sock_filter> compile(const ChannelFilter& filter) {
  std::vector<sock_filter> program;
  if (filter.own_port != 0) {
    append_if(program,
              {{{kWord, 0, 0, kSourceAddressAt}, filter.own_address},
               {{kHalf, 0, 0, 0}, filter.own_port}},
              {kDrop});
  }
  // Not of this run: passes. The first piece that differs jumps to a return of its own.
  for (const Comparison& step : comparisons(filter.prefix, kChannelAt)) {
    program.push_back(step.load);
    program.push_back({kEqual, 1, 0, step.value});
    program.push_back(kPass);
  }
  const auto prefix_size = filter.prefix.size();
  for (const std::string& channel : filter.channels) {
    // With the zero that ends it: "…_call" is not "…_caller".
    const std::string_view rest(channel.c_str() + prefix_size, channel.size() - prefix_size + 1);
    append_if(program, comparisons(rest, kChannelAt + static_cast<std::uint32_t>(prefix_size)),
              {kPass});
  }
  program.push_back(kDrop);
  return program;
}

}  // namespace tandem::wire
