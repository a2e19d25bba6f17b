#pragma once

#include <cstdint>
#include <string>

#include "protocol/wire/arrays.h"
#include "protocol/wire/bus.h"
#include "protocol/wire/call_times.h"
#include "protocol/wire/handshake.h"
#include "protocol/wire/liveness.h"
#include "protocol/wire/messages.h"

namespace tandem::wire {

class RemoteLinks;

/// Client end of the exchange with one side: numbered requests, one open at a time, repeated after
/// a time-out (20 ms, doubling to 200 ms) until the reply of the same number is here. The server
/// executes a number once, so each step is made exactly once on a lossy wire.
class RemoteLink {
 public:
  RemoteLink(Bus& bus, LivenessMonitor& monitor, RemoteOptions options);
  RemoteLink(const RemoteLink&) = delete;
  RemoteLink& operator=(const RemoteLink&) = delete;

  /// Says hello until the side says welcome. Throws tandem::Error (Usage) when it is of another
  /// version, scenario or port table.
  Handshake connect();

  /// Sends the request and waits for its reply; adds what it cost to `cost`. The header of
  /// `request.head` brings macro step and iteration alone. Throws tandem::Error with the side's
  /// name when the side threw, or is not heard any more, and when the reply does not hold
  /// what the call and the port table say. The reply lives until the next call; its
  /// values may be moved from.
  Reply& call(const RequestView& request, CallCost& cost);

  /// The two halves of call(): begin() sends and returns at once, finish() waits. In between the
  /// caller may do other work, or exchange with the other side over the same bus. With links to
  /// other sides begin() may leave the sending to them: RemoteLinks.
  void begin(const RequestView& request);
  Reply& finish(CallCost& cost);

  /// Checkpoint: the input given last is the accepted one.
  void accept_input();

  /// Whether `begin` has the bits of the accepted input, which the side still has.
  template <class In>
  [[nodiscard]] bool is_accepted(const In& begin) const {
    return !begin.empty() && same_bits(begin, ByteView(accepted_).last(accepted_bytes_));
  }

  /// Ends the side's server.
  void bye();

  [[nodiscard]] const CallCost& total() const { return total_; }

  /// Of the last call.
  [[nodiscard]] PartTimes times() const;

 private:
  friend class RemoteLinks;
  void send(Bytes& message, std::int32_t attempt, CallCost& cost);
  void send_first();
  /// The request leaves now, in one message with those of others; its first books the sending.
  void leaves(double time_s);
  [[nodiscard]] bool is_open() const { return sent_ && reply_bytes_ == 0; }
  /// From now on the time-out of the open request runs; once, until the next one is sent.
  void watch();
  void repeat_if_late();
  void await_reply();
  void book(double blocked_s);
  void on_reply(const Header& header, ByteView message);
  void check_reply() const;

  Bus& bus_;
  LivenessMonitor& monitor_;
  RemoteOptions options_;
  Subscription replies_;
  RemoteLinks* links_ = nullptr;  ///< that this is one of
  std::int64_t sequence_ = 0;
  std::int64_t macro_step_ = 0;
  std::int32_t iteration_ = 0;
  RequestKind call_ = RequestKind::Observe;  ///< of the open request
  CallCost open_cost_;                       ///< of the call in progress
  double begin_s_ = 0.0;                     ///< when it was first sent
  bool sent_ = false;                        ///< since begin(), until finish()
  bool watched_ = false;                     ///< its time-out runs
  double timeout_s_ = 0.0;
  double resend_s_ = 0.0;
  enum class Given { Nothing, Here, Lost };
  Bytes accepted_;                  ///< message that ends with the accepted input
  std::size_t accepted_bytes_ = 0;  ///< of that input; 0 = not known
  Given given_ = Given::Nothing;    ///< the input since: is it still in request_?
  std::size_t given_bytes_ = 0;
  Bytes request_;                ///< encoded; its memory serves every call
  Reply reply_;                  ///< of sequence_, once it is here
  std::size_t reply_bytes_ = 0;  ///< 0 while the call is open
  bool other_schema_ = false;    ///< the reply cannot be decoded
  double finish_s_ = 0.0;        ///< since when finish() has waited for it
  double arrival_s_ = 0.0;
  double decode_s_ = 0.0;               ///< checking and decoding it
  std::int64_t stale_ = 0;              ///< replies that came again, not booked yet
  std::int64_t server_duplicates_ = 0;  ///< as the server last reported
  CallCost total_;
};

}  // namespace tandem::wire
