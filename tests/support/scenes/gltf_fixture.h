// Small glTF documents made in code: a valid triangle that tests then damage or extend.
#pragma once

#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "core/gltf/gltf.h"

namespace test {

using Json = nlohmann::json;

constexpr int kUnsignedByte = 5121, kUnsignedShort = 5123, kUnsignedInt = 5125, kFloat = 5126;

std::string base64(std::span<const std::byte> bytes);

/// A document and its one buffer, which is embedded when the text is made.
struct Document {
    Json json;
    std::vector<std::byte> bin;

    /// Appends bytes as a buffer view; returns its index.
    int view(const void* data, size_t size, int stride = 0);
    /// Appends an accessor over a view.
    int accessor(int bufferView, int componentType, size_t count, const char* type);
    /// Both for tightly packed values.
    template <class T>
    int values(const std::vector<T>& data, int componentType, const char* type, size_t perElement)
    {
        return accessor(view(data.data(), data.size() * sizeof(T)), componentType,
                        data.size() / perElement, type);
    }
    Json& primitive() { return json["meshes"][0]["primitives"][0]; }
    Json& attributes() { return primitive()["attributes"]; }
    Json& material();  // the first, made and used when there is none yet

    std::string text() const;
    std::vector<std::byte> glb() const;
};

/// One triangle: accessor 0 positions (0,0,0) (1,0,0) (0,1,0), accessor 1 indices 0 1 2 as unsigned
/// short.
Document triangle();

/// The triangle with texture coordinates (accessor 2) and an image as base colour.
Document texturedTriangle(std::span<const std::byte> image);

std::span<const std::byte> bytesOf(const std::string& text);

std::shared_ptr<const core::Scene> load(const Document& document,
                                        const core::LoadOptions& options = {});
std::shared_ptr<const core::Scene> loadText(const std::string& text,
                                            const core::LoadOptions& options = {});

/// What refusing says; a test failure (and empty fields) when the text loads.
struct Refusal {
    std::string code, pointer, message;
};
Refusal refusal(const std::string& text, const core::LoadOptions& options = {});
Refusal fileRefusal(const std::filesystem::path& file, const core::LoadOptions& options = {});

/// The kept warning with that code; a test failure when there is none.
core::Warning warning(const core::Scene& scene, const std::string& code);

/// A folder of its own that disappears with the object.
class TemporaryFolder {
public:
    TemporaryFolder();
    ~TemporaryFolder();
    TemporaryFolder(const TemporaryFolder&) = delete;
    TemporaryFolder& operator=(const TemporaryFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }
    std::filesystem::path write(const std::string& name, std::span<const std::byte> bytes) const;
    std::filesystem::path write(const std::string& name, const std::string& text) const;

private:
    std::filesystem::path path_;
};

/// The bytes of an image file: png or jpg of 8-bit values, png of 16-bit values, exr or hdr (three
/// channels) of floats.
std::vector<std::byte> encodeImage(const std::string& extension, uint32_t width, uint32_t height,
                                   uint32_t channels, const std::vector<uint8_t>& pixels);
std::vector<std::byte> encodeImage(const std::string& extension, uint32_t width, uint32_t height,
                                   uint32_t channels, const std::vector<uint16_t>& pixels);
std::vector<std::byte> encodeImage(const std::string& extension, uint32_t width, uint32_t height,
                                   uint32_t channels, const std::vector<float>& pixels);

}  // namespace test

/// The text must be refused with this code at this JSON pointer, and the message must name file and
/// pointer.
#define EXPECT_REFUSED(text, expectedCode, expectedPointer)                                        \
    do {                                                                                           \
        const ::test::Refusal refused = ::test::refusal(text);                                     \
        EXPECT_EQ(refused.code, expectedCode) << refused.message;                                  \
        EXPECT_EQ(refused.pointer, expectedPointer) << refused.message;                            \
        EXPECT_EQ(refused.message.rfind("test.gltf: ", 0), 0u) << refused.message;                 \
        EXPECT_NE(refused.message.find(refused.pointer), std::string::npos) << refused.message;    \
        EXPECT_NE(refused.message.find(" — "), std::string::npos) << refused.message;              \
    } while (false)

/// The document must load with a warning of this code at this JSON pointer; `scene` is declared
/// with the result.
#define EXPECT_REPAIRED(scene, document, expectedCode, expectedPointer)                            \
    const std::shared_ptr<const ::core::Scene> scene = ::test::load(document);                     \
    ASSERT_TRUE(scene);                                                                            \
    EXPECT_EQ(::test::warning(*scene, expectedCode).pointer, expectedPointer)
