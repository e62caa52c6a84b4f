#include "client/viewer/scene_packer.h"

#include <gtest/gtest.h>

#include "client/viewer/gzip.h"

namespace palpate {
namespace {

SceneBytes Scene(std::uint64_t hash, std::uint8_t fill) {
  auto frame = std::make_shared<Frame>();
  frame->payload.assign(100'000, fill);
  return {frame, hash, frame->payload};
}

class ScenePackerTest : public testing::Test {
 protected:
  void Pack(const SceneBytes& scene) {
    packer_.Pack(scene, [this](const ScenePacker::Bytes& bytes) { given_.push_back(bytes); });
  }
  /// Waits for what is being compressed.
  void RunUntilGiven(std::size_t count) {
    while (given_.size() < count) io_.run_one();
  }

  boost::asio::io_context io_;
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_ =
      boost::asio::make_work_guard(io_);
  ScenePacker packer_{io_};
  std::vector<ScenePacker::Bytes> given_;
};

TEST_F(ScenePackerTest, GivesEachBundleItsOwnBytesAlsoWhileAnotherIsBeingPacked) {
  // One scene that a new server serves anew, under the same name.
  const SceneBytes former = Scene(1, 'a'), present = Scene(2, 'b');
  Pack(former);
  Pack(present);
  RunUntilGiven(2);
  EXPECT_EQ(*given_[0], Gzip(former.bundle));
  EXPECT_EQ(*given_[1], Gzip(present.bundle));
}

TEST_F(ScenePackerTest, PacksABundleOnceForAllThatAsk) {
  const SceneBytes scene = Scene(1, 'a');
  Pack(scene);
  Pack(scene);
  RunUntilGiven(2);
  Pack(scene);
  ASSERT_EQ(given_.size(), 3u) << "at once";
  EXPECT_EQ(given_[0], given_[1]);
  EXPECT_EQ(given_[0], given_[2]);
}

TEST_F(ScenePackerTest, ForgetsWhatNoSceneHas) {
  const SceneBytes kept = Scene(1, 'a'), gone = Scene(2, 'b');
  Pack(kept);
  Pack(gone);
  RunUntilGiven(2);
  packer_.KeepOnly({{"cube", kept}});
  Pack(kept);
  EXPECT_EQ(given_.size(), 3u);
  Pack(gone);
  EXPECT_EQ(given_.size(), 3u) << "it is packed anew";
  packer_.KeepOnly({});  // somebody waits for it
  RunUntilGiven(4);
  EXPECT_EQ(*given_[3], *given_[1]);
}

}  // namespace
}  // namespace palpate
