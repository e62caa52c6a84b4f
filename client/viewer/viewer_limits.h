#pragma once

#include <cstddef>
#include <cstdint>

namespace palpate {

/// What one viewer may have the gateway keep and do: nothing that a client sends makes either grow
/// without a bound.  How many viewers there may be is --max-viewers.
struct ViewerLimits {
  // --- what is kept of one ---

  /// A message of a client, in bytes: a pose has 150, the longest wish 2 kB.
  static constexpr std::size_t kLargestMessage = 64 * 1024;
  /// Items of a list in one: channels to subscribe to are a dozen.
  static constexpr std::size_t kMostItems = 256;
  /// Channels that a client may publish on: there are three.
  static constexpr std::size_t kMostChannels = 16;
  /// Texts that wait for one, and bytes of all of them; who does not read these is let go of.
  /// Frames that wait are bounded by what there is: the newest of each (frame_queue.h).
  static constexpr std::size_t kMostTexts = 64;
  static constexpr std::size_t kMostTextBytes = 128 * 1024;
  /// How long its farewell may take before it is let go of.
  static constexpr std::int64_t kFarewell_ns = 2'000'000'000;

  // --- what is done for one ---

  /// So many at once after a rest, and then one each period.
  struct Rate {
    int at_once;
    std::int64_t period_ns;
  };
  /// Bytes that are read, whatever they are, pings and empty fragments among them: beyond it they
  /// wait in the network.  Twice what the messages below have as poses.
  static constexpr double kBytesPerSecond = 128 * 1024;
  static constexpr double kBytesAtOnce = 256 * 1024;
  /// Messages that are read, likewise: a page drags a tool with each frame of a screen of 240 Hz.
  static constexpr double kMessagesPerSecond = 250;
  static constexpr double kMessagesAtOnce = 500;
  /// Complaints that it is told; the next one says how many were not.
  static constexpr Rate kComplaints{20, 500'000'000};

  // --- what it may wish: of itself, and of all viewers of its address together, which a class may
  // share and which makes as many viewers as it likes ---

  struct Wish {
    Rate of_viewer;
    Rate of_address;
  };
  /// Tools taken with the mouse: each starts a process, and ends one before long.  A hand takes a
  /// tool, gives it back and takes another within seconds now and then; of an address as many as
  /// there may be mice at once.
  static constexpr Wish kTake{{5, 2'000'000'000}, {32, 500'000'000}};
  /// Scenes made whole, which the server does once a second.
  static constexpr Wish kWhole{{3, 2'000'000'000}, {16, 1'000'000'000}};
  /// Of a replay: the page seeks five times a second while its bar is dragged.
  static constexpr Wish kReplay{{20, 100'000'000}, {60, 20'000'000}};
  /// About stations: a class of sixty admitted one by one at once.
  static constexpr Wish kOperate{{64, 100'000'000}, {128, 50'000'000}};
  /// Subscriptions, each of which is sent all that its channel keeps: all channels some times over,
  /// and 300 viewers of an address that come back together.
  static constexpr Wish kSubscribe{{64, 250'000'000}, {4096, 2'500'000}};
};

}  // namespace palpate
