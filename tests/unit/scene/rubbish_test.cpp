// Files that are not sound: every one ends in a UserError that names the file and what is wrong.
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <numeric>

#include "base/error.h"
#include "base/random.h"
#include "unit/scene/gltf_writer.h"

namespace prt {
namespace {

using testing::GltfWriter;
using testing::square_file;
using testing::TemporaryFolder;
using Json = nlohmann::json;

/// The message of the error that loading ends in; empty if it does not.
std::string error_of(const std::filesystem::path& file) {
  try {
    load_scene(file);
  } catch (const UserError& error) {
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << "one line";
    EXPECT_NE(std::string(error.what()).find(file.string()), std::string::npos) << error.what();
    return error.what();
  }
  return "";
}

std::string error_of_bytes(const std::string& bytes, const std::string& name = "scene.glb") {
  const TemporaryFolder folder;
  return error_of(folder.write(name, bytes));
}

void expect_says(const std::string& message, const std::string& part) {
  EXPECT_NE(message.find(part), std::string::npos)
      << "expected '" << part << "' in '" << message << "'";
}

TEST(Rubbish, Containers) {
  const TemporaryFolder folder;
  expect_says(error_of(folder.path() / "none.glb"), "does not exist");
  expect_says(error_of(folder.path()), "is a folder or a device, not a file");
  expect_says(error_of_bytes(""), "empty");
  expect_says(error_of_bytes("glTF"), "truncated");
  expect_says(error_of_bytes("solid cube"), "not a glTF file");
  expect_says(error_of_bytes("{}"), "not a glTF file");
  expect_says(error_of_bytes("[]"), "not a glTF file");
  expect_says(error_of_bytes(R"({"asset": {"version": "1.0"}})"), "version 1.0 is not 2.x");
  expect_says(error_of_bytes(R"({"asset": {}})"), "version");
  expect_says(error_of_bytes(R"({"asset": {"version": "2.0"}})"), "no triangle");
  expect_says(error_of_bytes(R"({"asset": {"version": "2.0"}, "nodes": [1e999]})"), "damaged");
  std::string version_one = square_file().glb();
  version_one[4] = 1;
  expect_says(error_of_bytes(version_one), "version 1 is not 2");
  expect_says(error_of_bytes(square_file().glb() + "more"), "bytes after its end");
  expect_says(error_of_bytes(GltfWriter::glb_of("{\"asset\":", "")), "damaged");
}

TEST(Rubbish, EveryTruncation) {
  const std::string bytes = square_file().glb();
  const TemporaryFolder folder;
  for (std::size_t size = 0; size < bytes.size(); size += 7) {
    EXPECT_FALSE(error_of(folder.write("cut.glb", bytes.substr(0, size))).empty()) << size;
    // The same with a header that admits it.
    if (size < 20) continue;
    std::string honest = bytes.substr(0, size);
    const auto length = static_cast<std::uint32_t>(size);
    std::memcpy(honest.data() + 8, &length, 4);
    EXPECT_FALSE(error_of(folder.write("cut.glb", honest)).empty()) << size;
  }
}

TEST(Rubbish, DeepJson) {
  const std::string brackets(200'000, '[');
  EXPECT_FALSE(error_of_bytes(brackets).empty());
  GltfWriter writer = square_file();
  std::string text = writer.gltf("x");
  text.insert(text.size() - 1, ",\"extras\":" + brackets + std::string(200'000, ']'));
  EXPECT_FALSE(error_of_bytes(text, "deep.gltf").empty());
  // Extras are not looked into; what the loader reads may not be deep.
  const std::string deep = std::string(20'000, '[') + std::string(20'000, ']');
  const auto with = [&](const std::string& key) {
    GltfWriter square = square_file();
    square.json["nodes"][0][key] = "DEEP";
    std::string bytes =
        square.gltf("data:application/octet-stream;base64," + testing::base64(square.binary));
    return error_of_bytes(bytes.replace(bytes.find("\"DEEP\""), 6, deep), "deep.gltf");
  };
  EXPECT_EQ(with("extras"), "");
  expect_says(with("weights"), "nested too deeply");
}

struct Spoilt {
  const char* name;
  std::function<void(Json&)> spoil;
  const char* says;
};

const std::vector<Spoilt>& spoilt_squares() {
  static const std::vector<Spoilt> all = {
      {"scene index", [](Json& j) { j["scene"] = 1; }, "scene: index 1 is out of range"},
      {"negative", [](Json& j) { j["scene"] = -1; }, "not a whole number"},
      {"fraction", [](Json& j) { j["scene"] = 0.5; }, "not a whole number"},
      {"huge", [](Json& j) { j["scene"] = 1e300; }, "not a whole number"},
      {"text for number", [](Json& j) { j["scene"] = "0"; }, "should be a number"},
      {"scene node", [](Json& j) { j["scenes"][0]["nodes"] = {7}; }, "scenes[0].nodes[0]"},
      {"node twice",
       [](Json& j) {
         j["scenes"][0]["nodes"] = {0, 0};
       },
       "listed twice"},
      {"nodes no array", [](Json& j) { j["nodes"] = 3; }, "nodes: should be an array"},
      {"node no object", [](Json& j) { j["nodes"][0] = 3; }, "should be an object"},
      {"mesh index", [](Json& j) { j["nodes"][0]["mesh"] = 1; }, "nodes[0].mesh"},
      {"child index", [](Json& j) { j["nodes"][0]["children"] = {9}; }, "children[0]"},
      {"own child", [](Json& j) { j["nodes"][0]["children"] = {0}; }, "node"},
      {"cycle",
       [](Json& j) {
         j["nodes"].push_back({{"children", {2}}});
         j["nodes"].push_back({{"children", {1}}});
       },
       "cycle"},
      {"two parents",
       [](Json& j) {
         j["nodes"].push_back({{"children", {0}}});
         j["nodes"].push_back({{"children", {0}}});
       },
       "two parents"},
      {"matrix size",
       [](Json& j) {
         j["nodes"][0]["matrix"] = {1, 2};
       },
       "array of 16 numbers"},
      {"projective", [](Json& j) { j["nodes"][0]["matrix"] = std::vector<int>(16, 1); },
       "last row"},
      {"zero quaternion",
       [](Json& j) {
         j["nodes"][0]["rotation"] = {0, 0, 0, 0};
       },
       "zero"},
      {"far away",
       [](Json& j) {
         j["nodes"][0]["translation"] = {1e16, 0, 0};
       },
       "beyond"},
      {"all flat",
       [](Json& j) {
         j["nodes"][0]["scale"] = {0, 1, 1};
       },
       "no triangle"},
      {"no attributes", [](Json& j) { j["meshes"][0]["primitives"][0].erase("attributes"); },
       "'attributes' is missing"},
      {"attribute index",
       [](Json& j) { j["meshes"][0]["primitives"][0]["attributes"]["POSITION"] = 99; },
       "attributes.POSITION: index 99"},
      {"attribute counts",
       [](Json& j) {
         j["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 0;
         j["accessors"][2]["count"] = 3;
         j["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 2;
       },
       "4 vertices have 3 elements"},
      {"mode", [](Json& j) { j["meshes"][0]["primitives"][0]["mode"] = 7; }, "not a mode"},
      {"material", [](Json& j) { j["meshes"][0]["primitives"][0]["material"] = 0; }, "materials"},
      {"float indices", [](Json& j) { j["meshes"][0]["primitives"][0]["indices"] = 0; },
       "unsigned integers"},
      {"index beyond vertices",
       [](Json& j) {
         for (int a : {0, 2, 3}) j["accessors"][a]["count"] = 3;
       },
       "index 3 is out of range"},
      {"component type", [](Json& j) { j["accessors"][0]["componentType"] = 5124; },
       "not a component type"},
      {"type", [](Json& j) { j["accessors"][0]["type"] = "VEC5"; }, "not a type"},
      {"positions of two", [](Json& j) { j["accessors"][0]["type"] = "VEC2"; }, "3 real numbers"},
      {"zero count", [](Json& j) { j["accessors"][0]["count"] = 0; }, "count 0"},
      {"one too many", [](Json& j) { j["accessors"][0]["count"] = 5; }, "out of range"},
      {"huge count", [](Json& j) { j["accessors"][0]["count"] = 4'000'000'000U; }, "out of range"},
      {"overflowing count", [](Json& j) { j["accessors"][0]["count"] = 1ULL << 62; }, "not"},
      {"zeros without end",
       [](Json& j) {
         j["accessors"][0].erase("bufferView");
         j["accessors"][0]["count"] = 4'000'000'000U;
       },
       "no bufferView"},
      {"accessor offset", [](Json& j) { j["accessors"][0]["byteOffset"] = 4; }, "out of range"},
      {"view index", [](Json& j) { j["accessors"][0]["bufferView"] = 50; }, "index 50"},
      {"small stride", [](Json& j) { j["bufferViews"][0]["byteStride"] = 8; }, "stride"},
      {"wide stride", [](Json& j) { j["bufferViews"][0]["byteStride"] = 16; }, "out of range"},
      {"view length", [](Json& j) { j["bufferViews"][0]["byteLength"] = 1e6; }, "bufferViews[0]"},
      {"view offset", [](Json& j) { j["bufferViews"][0]["byteOffset"] = 0x1p53; }, "out of range"},
      {"view buffer", [](Json& j) { j["bufferViews"][0]["buffer"] = 1; }, "bufferViews[0].buffer"},
      {"buffer length",
       [](Json& j) {
         j["buffers"] = {{{"byteLength", 1e11}}};
       },
       "are there"},
      {"second buffer without bytes",
       [](Json& j) {
         j["buffers"] = {{{"byteLength", 8}}, {{"byteLength", 8}}};
       },
       "no 'uri'"},
      {"sparse count",
       [](Json& j) {
         j["accessors"][0]["sparse"] = {{"count", 5}};
       },
       "sparse"},
      {"sparse indices",
       [](Json& j) {
         j["accessors"][0]["sparse"] = {
             {"count", 2},
             {"indices", {{"bufferView", 1}, {"byteOffset", 6}, {"componentType", 5123}}},
             {"values", {{"bufferView", 0}}}};
         j["accessors"][0]["sparse"]["indices"]["byteOffset"] = 4;  // 2, 0
       },
       "must increase"},
      {"draco", [](Json& j) { j["extensionsRequired"] = {"KHR_draco_mesh_compression"}; },
       "KHR_draco_mesh_compression"},
      {"alpha mode",
       [](Json& j) {
         j["materials"] = {{{"alphaMode", "GLASS"}}};
       },
       "GLASS"},
      {"base colour",
       [](Json& j) {
         j["materials"] = {{{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1}}}}}};
       },
       "array of 4 numbers"},
      {"texture index",
       [](Json& j) {
         j["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}};
       },
       "textures"},
      {"image index",
       [](Json& j) {
         j["textures"] = {{{"source", 3}}};
       },
       "images"},
      {"sampler index",
       [](Json& j) {
         j["textures"] = {{{"sampler", 3}}};
       },
       "samplers"},
      {"image view",
       [](Json& j) {
         j["images"] = {{{"bufferView", 77}}};
       },
       "images[0]"},
      {"image path",
       [](Json& j) {
         j["images"] = {{{"uri", "../a.png"}}};
       },
       "folder"},
      {"image without bytes",
       [](Json& j) {
         j["bufferViews"].push_back({{"buffer", 0}, {"byteLength", 0}});
         j["images"] = {{{"bufferView", j["bufferViews"].size() - 1}}};
       },
       "images[0]: the image is empty"},
      {"image twice",
       [](Json& j) {
         j["images"] = {{{"bufferView", 0}, {"uri", "a.png"}}};
       },
       "both"},
      {"camera without znear",
       [](Json& j) {
         j["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.7}}}}};
       },
       "cameras[0].perspective: 'znear' is missing"},
      {"negative attribute",
       [](Json& j) { j["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = -1; },
       "attributes.COLOR_0: -1"},
      {"odd stride",
       [](Json& j) {
         j["bufferViews"].push_back({{"buffer", 0}, {"byteLength", 4}, {"byteStride", 13}});
       },
       "tinygltf cannot read it"},
      {"light index",
       [](Json& j) { j["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0; }, "lights"},
      {"camera index", [](Json& j) { j["nodes"][0]["camera"] = 0; }, "cameras"},
  };
  return all;
}

TEST(Rubbish, SpoiltJson) {
  for (const Spoilt& spoilt : spoilt_squares()) {
    GltfWriter writer = square_file();
    spoilt.spoil(writer.json);
    const std::string message = error_of_bytes(writer.glb());
    EXPECT_NE(message.find(spoilt.says), std::string::npos)
        << spoilt.name << ": expected '" << spoilt.says << "' in '" << message << "'";
  }
}

TEST(Rubbish, SpoiltImages) {
  const std::string image = testing::png(4, 4, std::vector<std::uint8_t>(64, 200));
  for (std::size_t size = 0; size + 12 < image.size(); size += 5) {
    GltfWriter writer = square_file();
    testing::set_texture(writer, image.substr(0, size) + std::string(1, '\0'));
    expect_says(error_of_bytes(writer.glb()), "image");
  }
  GltfWriter bitmap = square_file();
  testing::set_texture(bitmap, "BM" + image.substr(2));
  expect_says(error_of_bytes(bitmap.glb()), "neither a PNG nor a JPEG");
  GltfWriter beyond = square_file();
  testing::set_texture(beyond, image);
  beyond.json["bufferViews"].back()["byteLength"] = image.size() + 100;
  expect_says(error_of_bytes(beyond.glb()), "out of range");
}

TEST(Rubbish, ImageBombs) {
  // A PNG's header that promises 16000 x 16000 pixels, and nothing behind it.
  std::string image = testing::png(4, 4, std::vector<std::uint8_t>(64, 200));
  for (const std::size_t at : {16U, 20U}) image.replace(at, 4, std::string("\0\0\x3e\x80", 4));
  GltfWriter writer = square_file();
  testing::set_texture(writer, image);
  expect_says(error_of_bytes(writer.glb()), "16000 x 16000");
}

TEST(Rubbish, Uris) {
  const GltfWriter writer = square_file();
  const TemporaryFolder outer;
  outer.write("secret.bin", writer.binary);
  outer.write("inside/own.bin", writer.binary);
  const auto error = [&](const std::string& uri) {
    return error_of(outer.write("inside/scene.gltf", writer.gltf(uri)));
  };
  EXPECT_EQ(error("own.bin"), "");
  EXPECT_EQ(error("./../inside/own.bin"), "") << "comes back to the folder";
  expect_says(error("../secret.bin"), "folder");
  expect_says(error("%2e%2e/secret.bin"), "folder");
  expect_says(error("..\\secret.bin"), "folder");
  expect_says(error("none/../../secret.bin"), "folder");
  expect_says(error((outer.path() / "secret.bin").string()), "folder");
  expect_says(error((outer.path() / "inside/own.bin").string()), "folder");
  expect_says(error("file:///etc/passwd"), "only data URIs");
  expect_says(error("http://example.com/a.bin"), "only data URIs");
  expect_says(error(""), "folder");
  expect_says(error("."), "folder");
  expect_says(error("own.bin%00"), "folder");
  expect_says(error("none.bin"), "does not exist");
  expect_says(error("data:,abc"), "base64");
  expect_says(error("data:application/octet-stream;base64,@@"), "damaged");
  expect_says(error("data:application/octet-stream;base64,AAAA"), "are there");
  std::filesystem::create_symlink(outer.path() / "secret.bin", outer.path() / "inside/link.bin");
  std::filesystem::create_directory_symlink(outer.path(), outer.path() / "inside/up");
  expect_says(error("link.bin"), "folder");
  expect_says(error("up/secret.bin"), "folder");
  std::filesystem::create_symlink("own.bin", outer.path() / "inside/good.bin");
  EXPECT_EQ(error("good.bin"), "");
}

/// A file with something of everything, so that a flipped bit can hit anything.
GltfWriter rich_file() {
  GltfWriter writer = square_file({{"rotation", {0, 0.6, 0, 0.8}}, {"scale", {1, 2, -1}}});
  testing::set_texture(writer, testing::png(2, 2, std::vector<std::uint8_t>(16, 180)));
  writer.json["materials"][0]["alphaMode"] = "MASK";
  writer.json["samplers"] = {{{"wrapS", 33648}, {"wrapT", 33071}}};
  writer.json["textures"][0]["sampler"] = 0;
  writer.json["accessors"][3]["sparse"] = {
      {"count", 1},
      {"indices", {{"bufferView", writer.add_view(std::string("\2", 1))}, {"componentType", 5121}}},
      {"values", {{"bufferView", writer.add_view(GltfWriter::bytes_of<float>({3, 3}))}}}};
  writer.add_mesh_node({{"attributes", {{"POSITION", 0}}}, {"mode", 5}},
                       {{"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 2, 0, 1, 0, 0, 0, 3, 1}}});
  writer.json["extensions"]["KHR_lights_punctual"]["lights"] = {
      {{"type", "spot"}, {"intensity", 5.0}, {"spot", {{"outerConeAngle", 0.5}}}}};
  writer.append("cameras",
                {{"type", "perspective"}, {"perspective", {{"yfov", 0.7}, {"znear", 0.1}}}});
  writer.add_node({{"camera", 0}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
  return writer;
}

bool all_finite(const Scene& scene) {
  const auto finite = [](const auto& vectors) {
    return std::all_of(vectors.begin(), vectors.end(),
                       [](const auto& vector) { return vector.allFinite(); });
  };
  bool result = finite(scene.positions) && finite(scene.normals) && finite(scene.uvs) &&
                scene.uvs.size() == scene.positions.size() &&
                scene.normals.size() == scene.positions.size();
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
    result = result && triangle_normal(scene, t).allFinite() && triangle_area(scene, t) > 0.0 &&
             albedo_at(scene, t, 0.3F, 0.3F).allFinite();
    static_cast<void>(opaque_at(scene, t, 0.3F, 0.3F));
  }
  for (const SceneLight& light : scene.lights) {
    result = result && light.intensity.allFinite() && light.position.allFinite() &&
             std::abs(light.direction.norm() - 1.0F) < 1e-5F;
  }
  return result;
}

/// Flips one to eight bits; the file ends in a UserError or in a finite scene.
void fuzz(const std::string& sound, int tries, bool binary) {
  const TemporaryFolder folder;
  int refused = 0;
  for (int i = 0; i < tries; ++i) {
    Random random(stream_key(1, binary ? "fuzz glb" : "fuzz gltf"), static_cast<std::uint64_t>(i));
    std::string bytes = sound;
    const std::uint32_t flips = 1 + random.below(8);
    for (std::uint32_t k = 0; k < flips; ++k) {
      const auto at = random.below(static_cast<std::uint32_t>(bytes.size()));
      bytes[at] = static_cast<char>(static_cast<unsigned char>(bytes[at]) ^ 1U << random.below(8));
    }
    try {
      EXPECT_TRUE(all_finite(load_scene(folder.write("flipped", bytes)))) << "try " << i;
    } catch (const UserError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, tries / 10) << "the flips must hit something";
  EXPECT_LT(refused, tries) << "and not always";
}

/// PRT_FUZZ_TRIES and PRT_FUZZ_FILE ask for more tries, and for another file.
TEST(Rubbish, FlippedBits) {
  const char* tries = std::getenv("PRT_FUZZ_TRIES");
  const int count = tries == nullptr ? 200 : std::atoi(tries);
  if (const char* file = std::getenv("PRT_FUZZ_FILE")) {
    std::ifstream stream(file, std::ios::binary);
    fuzz({std::istreambuf_iterator<char>(stream), {}}, count, true);
    return;
  }
  const GltfWriter writer = rich_file();
  fuzz(writer.glb(), count, true);
  fuzz(writer.gltf("data:application/octet-stream;base64," + testing::base64(writer.binary)), count,
       false);
}

}  // namespace
}  // namespace prt
