#include "protocol/wire/liveness.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>

#include "protocol/contract/cost.h"
#include "protocol/contract/error.h"

namespace tandem::wire {
namespace {

// A gap in our own listening longer than this (a long solver step, SIGSTOP) deserves a second look
// before a partner is declared dead.
constexpr double kGap_s = 0.25;
constexpr double kGrace_s = 1.0;

ErrorKind kind_of_exit_code(int code) {
  switch (code) {
    case 2:
      return ErrorKind::Usage;
    case 3:
      return ErrorKind::NotSolved;
    case 5:
      return ErrorKind::ReplayDiffers;
    default:
      return ErrorKind::Partner;
  }
}

}  // namespace

Heartbeat::Heartbeat(Bus& bus, double timeout_s)
    : bus_(bus), period_s_(std::min(0.2, timeout_s / 5.0)), thread_([this] { loop(); }) {}

Heartbeat::~Heartbeat() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_one();
  thread_.join();
}

void Heartbeat::set_phase(const std::string& phase) {
  {
    const std::lock_guard lock(mutex_);
    phase_ = phase;
    say_now_ = true;
  }
  changed_.notify_one();
}

void Heartbeat::loop() {
  std::unique_lock lock(mutex_);
  for (std::int64_t sequence = 1; !stop_; ++sequence) {
    Alive alive{bus_.header(Kind::Alive, sequence), static_cast<std::int32_t>(getpid()), phase_};
    alive.header.macro_step = macro_step_;
    say_now_ = false;
    lock.unlock();
    Bytes message = encode(alive);
    bus_.publish(bus_.options().self, Kind::Alive, message);
    lock.lock();
    changed_.wait_for(lock, std::chrono::duration<double>(period_s_),
                      [this] { return stop_ || say_now_; });
  }
}

void publish_abort(Bus& bus, int exit_code, const std::string& text) {
  constexpr int kRepetitions = 5;
  Bytes message = encode(Abort{bus.header(Kind::Abort, 1), exit_code, text});
  for (int attempt = 0; attempt < kRepetitions; ++attempt) {
    bus.publish(bus.options().self, Kind::Abort, message, attempt);
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

LivenessMonitor::LivenessMonitor(Bus& bus, std::vector<Process> partners, double timeout_s,
                                 int parent_pid)
    : bus_(bus), partners_(partners.size()), timeout_s_(timeout_s), parent_pid_(parent_pid) {
  const double time_s = now_s();
  last_check_s_ = time_s;
  for (std::size_t i = 0; i < partners.size(); ++i) {
    Partner& partner = partners_[i];
    partner.process = partners[i];
    partner.deadline_s = time_s + timeout_s;
    partner.alive = bus.subscribe(partner.process, Kind::Alive,
                                  [this, i](const Header& header, ByteView bytes) {
                                    const auto alive = decode_alive(bytes);
                                    if (!alive) return bus_.count_undecodable();
                                    partners_[i].phase = alive->phase;
                                    partners_[i].macro_step = header.macro_step;
                                  });
    partner.abort =
        bus.subscribe(partner.process, Kind::Abort, [this](const Header&, ByteView bytes) {
          const auto abort = decode_abort(bytes);
          if (!abort) return bus_.count_undecodable();
          on_abort(*abort);
        });
  }
}

bool LivenessMonitor::wait(double seconds) {
  const bool arrived = bus_.pump(std::min(seconds, kGap_s / 2.0));
  if (arrived) {
    look(now_s());
    if (now_s() - last_check_s_ < kGap_s / 2.0) return true;
    // The heartbeats of one partner may come more often than that: they must not hide the silence
    // of another one.
    if (bus_.pump(0.0)) {
      look(now_s());
      return true;
    }
  }
  // Only with an empty socket is it known what the partners have said up to now.
  check(now_s());
  if (also_watch_) also_watch_();
  return arrived;
}

void LivenessMonitor::look(double time_s) {
  for (Partner& partner : partners_) {
    const std::int64_t heard = bus_.heard()[static_cast<std::size_t>(partner.process)];
    if (heard == partner.heard) continue;
    partner.heard = heard;
    partner.deadline_s = time_s + timeout_s_;
    partner.grace_given = false;
  }
}

void LivenessMonitor::check(double time_s) {
  const bool gap = time_s - last_check_s_ > kGap_s;
  last_check_s_ = time_s;
  if (parent_pid_ > 0 && getppid() != parent_pid_) {
    throw Error(ErrorKind::Partner,
                fmt::format("{}: the process that started it (pid {}) has ended (macro step {})",
                            bus_.name_of(bus_.options().self), parent_pid_, macro_step_));
  }
  for (Partner& partner : partners_) {
    if (partner.released || time_s < partner.deadline_s) continue;
    if (!gap || partner.grace_given) fail_silent(partner);
    partner.grace_given = true;
    partner.deadline_s = time_s + std::min(kGrace_s, timeout_s_);
  }
}

void LivenessMonitor::release(Process process) {
  for (Partner& partner : partners_) partner.released |= partner.process == process;
}

void LivenessMonitor::on_abort(const Abort& abort) const {
  constexpr const char* kEnded = " ended with exit code ";
  // A process that ended because another one did passes on that one's words.
  const bool passed_on = abort.text.find(kEnded) != std::string::npos;
  throw Error(kind_of_exit_code(abort.exit_code),
              passed_on ? abort.text
                        : fmt::format("{}{}{}: {}", bus_.program_of(abort.header.sender), kEnded,
                                      abort.exit_code, abort.text));
}

void LivenessMonitor::fail_silent(const Partner& partner) const {
  const std::string error = bus_.send_error();
  const std::string sending = error.empty() ? "" : " Sending fails here: " + error + ".";
  if (partner.heard == 0) {
    throw Error(
        ErrorKind::Partner,
        fmt::format(
            "{}: {} has not been heard within {:.3g} s: it was not started, ended early, or "
            "uses another run id or multicast port (here: port {}).{}",
            bus_.name_of(bus_.options().self), bus_.program_of(partner.process), timeout_s_,
            bus_.options().port, sending));
  }
  throw Error(
      ErrorKind::Partner,
      fmt::format("{}: nothing heard from {} for {:.3g} s (macro step {}; it was last {}): "
                  "it was stopped, killed or lost its network.{}{}",
                  bus_.name_of(bus_.options().self), bus_.program_of(partner.process), timeout_s_,
                  macro_step_, partner.phase.empty() ? "answering" : partner.phase,
                  others_than(partner), sending));
}

// Of several flexible bodies or worlds: who else is missing, and what the others are doing.
std::string LivenessMonitor::others_than(const Partner& silent) const {
  if (!bus_.options().names.several()) return {};
  const double time_s = now_s();
  std::string missing, others;
  for (const Partner& partner : partners_) {
    if (partner.released || !(is_flexible(partner.process) || is_multibody(partner.process))) {
      continue;
    }
    const std::string asked = tell_ ? tell_(partner.process) : std::string();
    if (&partner == &silent) {
      if (!asked.empty()) missing += fmt::format(" {} {}.", bus_.program_of(silent.process), asked);
      continue;
    }
    // Heartbeats come five times in a time-out, or more often.
    const bool is_missing = partner.grace_given || partner.deadline_s - time_s < 0.5 * timeout_s_;
    (is_missing ? missing : others) += fmt::format(
        " {} {} (macro step {}, {}){}{}.", bus_.program_of(partner.process),
        is_missing ? "is not heard either" : "lives", partner.macro_step,
        partner.phase.empty() ? "answering" : partner.phase, asked.empty() ? "" : ", ", asked);
  }
  return missing + others;
}

const LivenessMonitor::Partner* LivenessMonitor::find(Process process) const {
  const auto found = std::find_if(partners_.begin(), partners_.end(), [&](const Partner& partner) {
    return partner.process == process;
  });
  return found == partners_.end() ? nullptr : &*found;
}

const std::string& LivenessMonitor::phase(Process process) const {
  static const std::string kNone;
  const Partner* partner = find(process);
  return partner == nullptr ? kNone : partner->phase;
}

std::int64_t LivenessMonitor::macro_step(Process process) const {
  const Partner* partner = find(process);
  return partner == nullptr ? 0 : partner->macro_step;
}

bool LivenessMonitor::heard_from(Process process) const {
  const Partner* partner = find(process);
  return partner != nullptr && partner->heard > 0;
}

}  // namespace tandem::wire
