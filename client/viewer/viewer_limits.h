#pragma once

#include <cstddef>
#include <cstdint>

namespace palpate {

/// Bounds on the memory and work that one viewer can cause, whatever it sends.  The number of
/// viewers is bounded by --max-viewers.
struct ViewerLimits {
  // --- memory per viewer ---

  /// Bytes of a client's message; a pose has 150, the longest command 2 kB.
  static constexpr std::size_t kLargestMessage = 64 * 1024;
  /// Items of a list in a message; there are 19 channels to subscribe to.
  static constexpr std::size_t kMostItems = 256;
  /// Channels on which a client may publish; there are six topics.
  static constexpr std::size_t kMostChannels = 16;
  /// Texts that wait for a viewer, and their total bytes; a viewer that does not read them is
  /// dropped.  Waiting frames are bounded by the number of instances (frame_queue.h).
  static constexpr std::size_t kMostTexts = 64;
  static constexpr std::size_t kMostTextBytes = 128 * 1024;
  /// How long an orderly close may take before the viewer is dropped.
  static constexpr std::int64_t kFarewell_ns = 2'000'000'000;

  // --- work per viewer ---

  /// A rate limit: `at_once` after a rest, then one per period.
  struct Rate {
    int at_once;
    std::int64_t period_ns;
  };
  /// Bytes read, of any kind, including pings and empty fragments; what exceeds the rate waits in
  /// the network.  That is more than three times the bytes of kMessagesPerSecond poses.
  static constexpr double kBytesPerSecond = 128 * 1024;
  static constexpr double kBytesAtOnce = 256 * 1024;
  /// Messages read, likewise: a page sends a pose per frame, up to 240 Hz.
  static constexpr double kMessagesPerSecond = 250;
  static constexpr double kMessagesAtOnce = 500;
  /// Complaints sent to it; the next one says how many were left out.
  static constexpr Rate kComplaints{20, 500'000'000};

  /// A tool that was not moved with the mouse for this long is taken from its viewer; and one whose
  /// viewer has gone rests for so long, in case the viewer comes back.
  static constexpr std::int64_t kMouseIdle_ns = 300'000'000'000;
  static constexpr std::int64_t kMouseAway_ns = 30'000'000'000;

  // --- limits of wishes: per viewer, and for all viewers of an address together, since a class may
  // share an address and one host can open many viewers ---

  struct Wish {
    Rate of_viewer;
    Rate of_address;
  };
  /// Tools taken with the mouse; each starts a process and soon ends another.  A user may
  /// take, release and take again within seconds; an address may take as many as there can be
  /// mice at once.
  static constexpr Wish kTake{{5, 2'000'000'000}, {32, 500'000'000}};
  /// Scenes restored; the server does so once a second.
  static constexpr Wish kWhole{{3, 2'000'000'000}, {16, 1'000'000'000}};
  /// Commands to a replay: the page seeks five times a second while its bar is dragged.
  static constexpr Wish kReplay{{20, 100'000'000}, {60, 20'000'000}};
  /// Decisions about stations: a class of sixty may be admitted one by one in quick succession.
  static constexpr Wish kOperate{{64, 100'000'000}, {128, 50'000'000}};
  /// Subscriptions, each answered with all that its channel keeps: several times all channels, or
  /// 300 viewers of an address that reconnect together.
  static constexpr Wish kSubscribe{{64, 250'000'000}, {4096, 2'500'000}};
};

}  // namespace palpate
