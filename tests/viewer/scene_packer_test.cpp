#include "client/viewer/scene_packer.h"

#include <gtest/gtest.h>
#include <zlib.h>

namespace palpate {
namespace {

std::vector<std::uint8_t> Unpacked(const PackedScene::Bytes& packed, std::size_t most) {
  std::vector<std::uint8_t> bytes(most);
  z_stream stream{};
  EXPECT_EQ(inflateInit2(&stream, MAX_WBITS + 16), Z_OK);  // gzip only
  stream.next_in = const_cast<Bytef*>(packed->data());
  stream.avail_in = static_cast<uInt>(packed->size());
  stream.next_out = bytes.data();
  stream.avail_out = static_cast<uInt>(bytes.size());
  EXPECT_EQ(inflate(&stream, Z_FINISH), Z_STREAM_END);
  bytes.resize(stream.total_out);
  inflateEnd(&stream);
  return bytes;
}

SceneBytes Scene(std::size_t size, std::size_t period) {
  auto frame = std::make_shared<Frame>();
  for (std::size_t i = 0; i < size; ++i) {
    frame->payload.push_back(static_cast<std::uint8_t>(i / 100 % period));
  }
  return {frame, 0, frame->payload};
}

class ScenePackerTest : public testing::Test {
 protected:
  void Pack(const SceneBytes& scene) {
    packer_.Pack(scene, [this](const PackedScene::Bytes& bytes) { given_.push_back(bytes); });
  }
  /// Runs until `count` bundles were compressed.
  void RunUntilGiven(std::size_t count) {
    while (given_.size() < count) io_.run_one();
  }

  boost::asio::io_context io_;
  boost::asio::executor_work_guard<boost::asio::io_context::executor_type> work_ =
      boost::asio::make_work_guard(io_);
  ScenePacker packer_{io_};
  std::vector<PackedScene::Bytes> given_;
};

TEST_F(ScenePackerTest, GivesEachBundleItsOwnBytesAlsoWhileAnotherIsBeingPacked) {
  std::vector<SceneBytes> scenes;
  for (const std::size_t size : {0u, 1u, 1'000'000u}) scenes.push_back(Scene(size, 7));
  scenes.push_back(Scene(1'000'000, 5));  // as from a new server, under the same name
  for (const SceneBytes& scene : scenes) Pack(scene);
  RunUntilGiven(scenes.size());
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    const std::vector<std::uint8_t>& bytes = scenes[i].frame->payload;
    EXPECT_TRUE(Unpacked(given_[i], bytes.size() + 1) == bytes) << i;
    EXPECT_LT(given_[i]->size(), 50 + bytes.size() / 20);
  }
}

TEST_F(ScenePackerTest, PacksABundleOnceForAllThatAsk) {
  const SceneBytes scene = Scene(100, 7);
  Pack(scene);
  Pack(scene);
  RunUntilGiven(2);
  Pack(scene);
  ASSERT_EQ(given_.size(), 3u) << "at once";
  EXPECT_EQ(given_[0], given_[1]);
  EXPECT_EQ(given_[0], given_[2]);
}

}  // namespace
}  // namespace palpate
