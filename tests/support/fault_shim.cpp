// Shared library for LD_PRELOAD: disturbs the UDP multicast that a process sends, by a seeded
// generator, so that a failing run can be repeated. Percentages of datagrams:
//   TANDEM_FAULT_DROP_PERCENT       not sent
//   TANDEM_FAULT_DUPLICATE_PERCENT  sent twice
//   TANDEM_FAULT_REORDER_PERCENT    held, and sent behind the next datagram of the process
//   TANDEM_FAULT_FLIP_PERCENT       one bit of the last 64 bytes flipped
//   TANDEM_FAULT_SLEEP_US           sleeps a random time up to this before each datagram
//   TANDEM_FAULT_RECEIVE_BUFFER     bytes that a socket's receive buffer is given at most, as by
//                                   net.core.rmem_max
//   TANDEM_FAULT_SEED               seed; mixed with the program's name and that of its body
// With TANDEM_FAULT_PROGRAM, only the process of that name is disturbed. It may also end at a
// chosen point of the exchange, before that datagram is sent:
//   TANDEM_FAULT_END                how: kill, stop (SIGSTOP), or an exit code
//   TANDEM_FAULT_END_KIND           … at a datagram whose channel ends so, e.g. "_reply"
//   TANDEM_FAULT_END_COUNT          … the n-th of them [1]
#include <dlfcn.h>
#include <errno.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <mutex>
#include <string>
#include <vector>

namespace {

using SendMessage = ssize_t (*)(int, const msghdr*, int);
using SendTo = ssize_t (*)(int, const void*, size_t, int, const sockaddr*, socklen_t);

double setting(const char* name) {
  const char* text = std::getenv(name);
  return text == nullptr ? 0.0 : std::atof(text);
}

std::string text_setting(const char* name) {
  const char* text = std::getenv(name);
  return text == nullptr ? "" : text;
}

bool concerns_this_program() {
  const std::string chosen = text_setting("TANDEM_FAULT_PROGRAM");
  return chosen.empty() || chosen == program_invocation_short_name;
}

/// What stands behind --body on the command line: several bodies are processes of one program.
std::string body_of_this_process() {
  std::ifstream file("/proc/self/cmdline");
  std::string word, before;
  while (std::getline(file, word, '\0')) {
    if (before == "--body") return word;
    before = word;
  }
  return {};
}

// A datagram of LCM begins with 8 bytes (magic, number); the channel follows, ended by a zero.
std::string channel_of(const std::vector<char>& datagram) {
  if (datagram.size() < 9) return {};
  return {datagram.data() + 8, strnlen(datagram.data() + 8, datagram.size() - 8)};
}

struct Held {
  int fd = -1;
  sockaddr_storage address{};
  socklen_t address_size = 0;
  std::vector<char> bytes;
};

struct Shim {
  std::mutex mutex;
  std::uint64_t state = static_cast<std::uint64_t>(setting("TANDEM_FAULT_SEED")) + 1;
  double drop = setting("TANDEM_FAULT_DROP_PERCENT");
  double duplicate = setting("TANDEM_FAULT_DUPLICATE_PERCENT");
  double reorder = setting("TANDEM_FAULT_REORDER_PERCENT");
  double flip = setting("TANDEM_FAULT_FLIP_PERCENT");
  double sleep_us = setting("TANDEM_FAULT_SLEEP_US");
  SendTo send_to = reinterpret_cast<SendTo>(dlsym(RTLD_NEXT, "sendto"));
  SendMessage send_message = reinterpret_cast<SendMessage>(dlsym(RTLD_NEXT, "sendmsg"));
  Held held;
  bool active = concerns_this_program();
  std::string end = text_setting("TANDEM_FAULT_END");
  std::string end_kind = text_setting("TANDEM_FAULT_END_KIND");
  double end_count = setting("TANDEM_FAULT_END_COUNT");

  Shim() {
    for (const char c : program_invocation_short_name + body_of_this_process()) {
      state = state * 31 + static_cast<unsigned char>(c);
    }
  }
  // splitmix64 [Steele, Lea, Flood 2014]
  std::uint64_t next() {
    std::uint64_t z = (state += 0x9e3779b97f4a7c15ULL);
    z = (z ^ (z >> 30U)) * 0xbf58476d1ce4e5b9ULL;
    z = (z ^ (z >> 27U)) * 0x94d049bb133111ebULL;
    return z ^ (z >> 31U);
  }
  bool happens(double percent) { return static_cast<double>(next() % 100000U) < 1000.0 * percent; }
};

Shim& shim() {
  static Shim instance;
  return instance;
}

bool is_multicast(const sockaddr* address) {
  if (address == nullptr || address->sa_family != AF_INET) return false;
  const auto* internet = reinterpret_cast<const sockaddr_in*>(address);
  return (ntohl(internet->sin_addr.s_addr) >> 28U) == 0xeU;
}

void send_held(Shim& s) {
  if (s.held.fd < 0) return;
  s.send_to(s.held.fd, s.held.bytes.data(), s.held.bytes.size(), 0,
            reinterpret_cast<const sockaddr*>(&s.held.address), s.held.address_size);
  s.held.fd = -1;
}

void end_this_process_at(Shim& s, const std::vector<char>& datagram) {
  if (s.end.empty() || !channel_of(datagram).ends_with(s.end_kind) || --s.end_count > 0.0) return;
  if (s.end == "kill") kill(getpid(), SIGKILL);
  if (s.end != "stop") _exit(std::atoi(s.end.c_str()));
  s.end.clear();  // continued, it goes on
  kill(getpid(), SIGSTOP);
}

ssize_t disturb(int fd, std::vector<char> bytes, int flags, const sockaddr* address,
                socklen_t address_size) {
  Shim& s = shim();
  const std::lock_guard lock(s.mutex);
  const auto size = static_cast<ssize_t>(bytes.size());
  end_this_process_at(s, bytes);
  if (s.sleep_us > 0.0) {
    const auto pause = static_cast<long>(s.next() % static_cast<std::uint64_t>(s.sleep_us + 1.0));
    const timespec time{pause / 1000000, (pause % 1000000) * 1000};
    nanosleep(&time, nullptr);
  }
  if (s.happens(s.drop)) return size;
  if (s.happens(s.flip) && bytes.size() > 64) {
    bytes[bytes.size() - 1 - s.next() % 64U] ^= static_cast<char>(1U << (s.next() % 8U));
  }
  if (s.held.fd < 0 && s.happens(s.reorder)) {
    s.held.fd = fd;
    std::memcpy(&s.held.address, address, address_size);
    s.held.address_size = address_size;
    s.held.bytes = std::move(bytes);
    return size;
  }
  const ssize_t result = s.send_to(fd, bytes.data(), bytes.size(), flags, address, address_size);
  if (s.happens(s.duplicate)) {
    s.send_to(fd, bytes.data(), bytes.size(), flags, address, address_size);
  }
  send_held(s);
  return result;
}

using SetOption = int (*)(int, int, int, const void*, socklen_t);

}  // namespace

extern "C" {

__attribute__((visibility("default"))) int setsockopt(int fd, int level, int option,
                                                      const void* value, socklen_t size) {
  static const auto kNext = reinterpret_cast<SetOption>(dlsym(RTLD_NEXT, "setsockopt"));
  static const auto kMost = static_cast<int>(setting("TANDEM_FAULT_RECEIVE_BUFFER"));
  int bytes = 0;
  if (kMost == 0 || level != SOL_SOCKET || option != SO_RCVBUF || size != sizeof(bytes)) {
    return kNext(fd, level, option, value, size);
  }
  std::memcpy(&bytes, value, sizeof(bytes));
  bytes = bytes < kMost ? bytes : kMost;
  return kNext(fd, level, option, &bytes, sizeof(bytes));
}

__attribute__((visibility("default"))) ssize_t sendmsg(int fd, const msghdr* message, int flags) {
  const auto* address = static_cast<const sockaddr*>(message->msg_name);
  if (!shim().active || !is_multicast(address)) {
    return shim().send_message(fd, message, flags);
  }
  std::vector<char> bytes;
  for (size_t i = 0; i < message->msg_iovlen; ++i) {
    const auto* begin = static_cast<const char*>(message->msg_iov[i].iov_base);
    bytes.insert(bytes.end(), begin, begin + message->msg_iov[i].iov_len);
  }
  return disturb(fd, std::move(bytes), flags, address, message->msg_namelen);
}

__attribute__((visibility("default"))) ssize_t sendto(int fd, const void* data, size_t size,
                                                      int flags, const sockaddr* address,
                                                      socklen_t address_size) {
  if (!shim().active || !is_multicast(address)) {
    return shim().send_to(fd, data, size, flags, address, address_size);
  }
  const auto* begin = static_cast<const char*>(data);
  return disturb(fd, {begin, begin + size}, flags, address, address_size);
}
}
