#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "protocol/wire/channel_filter.h"

namespace tandem::wire {
namespace {

/// The kernel's answer: how many of the sent messages a filtered socket lets through.
TEST(WireFilter, PassesWantedChannelsAndOtherProgramsAlone) {
  ChannelFilter filter{.prefix = "TANDEM_0000000000000001_",
                       .channels = {"TANDEM_0000000000000001_fem_reply",
                                    "TANDEM_0000000000000001_orchestrator_credit"}};
  const std::vector<sock_filter> steps = compile(filter);
  const sock_fprog program{static_cast<unsigned short>(steps.size()),
                           const_cast<sock_filter*>(steps.data())};
  const int receiver = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof(address);
  ASSERT_EQ(bind(receiver, reinterpret_cast<sockaddr*>(&address), size), 0);
  ASSERT_EQ(getsockname(receiver, reinterpret_cast<sockaddr*>(&address), &size), 0);
  ASSERT_EQ(setsockopt(receiver, SOL_SOCKET, SO_ATTACH_FILTER, &program, sizeof(program)), 0);
  const int sender = socket(AF_INET, SOCK_DGRAM, 0);
  const auto passes = [&](const std::string& channel) {
    const std::string message = "LC02" + std::string(4, 'n') + channel + '\0' + "payload";
    sendto(sender, message.data(), message.size(), 0, reinterpret_cast<sockaddr*>(&address), size);
    char byte = 0;
    return recv(receiver, &byte, 1, MSG_DONTWAIT) > 0;
  };
  EXPECT_TRUE(passes("TANDEM_0000000000000001_fem_reply"));
  EXPECT_TRUE(passes("TANDEM_0000000000000001_orchestrator_credit"));
  EXPECT_TRUE(passes("TANDEM_0000000000000002_fem_request"));
  EXPECT_TRUE(passes("ANOTHER_PROGRAM_WITH_A_LONG_CHANNEL"));
  EXPECT_FALSE(passes("TANDEM_0000000000000001_fem_request"));
  EXPECT_FALSE(passes("TANDEM_0000000000000001_fem_repl"));
  EXPECT_FALSE(passes("TANDEM_0000000000000001_fem_replys"));
  EXPECT_FALSE(passes("TANDEM_0000000000000001_orchestrator_journal"));
  close(sender);
  close(receiver);
}

}  // namespace
}  // namespace tandem::wire
