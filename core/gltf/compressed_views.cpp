// EXT_meshopt_compression and KHR_meshopt_compression: the rules of the extension, and the only
// file that sees meshoptimizer. Its decoders are made for untrusted bytes: they check every read
// and write, and what comes out (any indices, any floats) is checked as if it had been stored so.
#include <meshoptimizer.h>

#include "core/gltf/compression.h"

namespace core::gltf {

namespace {

/// No stream is smaller than a thousandth of what it stands for: attributes take at least two bits
/// per byte of an element and block of 256 elements, indices far more. So memory is taken for no
/// lie.
constexpr uint64_t kLargestRatio = 1024;

struct Stream {
    std::string mode, filter;
    uint64_t stride = 0, count = 0;
    std::span<const std::byte> bytes;
};

void requireMode(Load& load, const Object& extension, const Stream& stream)
{
    if (stream.mode == "ATTRIBUTES") {
        if (stream.stride == 0 || stream.stride % 4 != 0 || stream.stride > 256)
            load.refuse("VALUE_NOT_IN_RANGE", extension.at("byteStride"),
                        "is " + std::to_string(stream.stride) +
                            ", must be a multiple of 4 up to 256 for ATTRIBUTES");
        return;
    }
    if (stream.mode != "TRIANGLES" && stream.mode != "INDICES")
        load.refuse("VALUE_NOT_IN_LIST", extension.at("mode"),
                    "is " + describe(stream.mode) + ", must be ATTRIBUTES, TRIANGLES or INDICES");
    if (stream.stride != 2 && stream.stride != 4)
        load.refuse("VALUE_NOT_IN_LIST", extension.at("byteStride"),
                    "is " + std::to_string(stream.stride) + ", must be 2 or 4 for indices");
    if (stream.mode == "TRIANGLES" && stream.count % 3 != 0)
        load.refuse("VALUE_NOT_IN_RANGE", extension.at("count"),
                    "is " + std::to_string(stream.count) + ", must be a multiple of 3");
}

void requireFilter(Load& load, const Object& extension, const Stream& stream)
{
    const std::string& filter = stream.filter;
    if (filter == "NONE") return;
    const std::string at = extension.at("filter");
    if (filter == "COLOR")  // of KHR_meshopt_compression, and of newer libraries than Debian's
        load.refuse("UNSUPPORTED_EXTENSION", at, "is COLOR, which is not supported",
                    "decode it first, e.g. gltf-transform copy in.glb out.glb");
    if (filter != "OCTAHEDRAL" && filter != "QUATERNION" && filter != "EXPONENTIAL")
        load.refuse("VALUE_NOT_IN_LIST", at,
                    "is " + describe(filter) +
                        ", must be NONE, OCTAHEDRAL, QUATERNION or EXPONENTIAL");
    if (stream.mode != "ATTRIBUTES")
        load.refuse("VALUE_NOT_IN_LIST", at, "is " + filter + ", indices have no filter");
    const bool fits = filter == "EXPONENTIAL" || stream.stride == 8 ||
                      (filter == "OCTAHEDRAL" && stream.stride == 4);
    if (!fits)
        load.refuse("VALUE_NOT_IN_LIST", extension.at("byteStride"),
                    "is " + std::to_string(stream.stride) + ", which " + filter + " cannot have");
}

/// The extension's rules, which also are what meshoptimizer asserts.
Stream readStream(Load& load, const Object& view, const Object& extension)
{
    Stream stream;
    stream.mode = extension.requiredString("mode");
    stream.filter = extension.has("filter") ? extension.requiredString("filter") : "NONE";
    stream.stride = extension.requiredInteger("byteStride");
    stream.count = extension.requiredInteger("count");
    if (stream.count == 0)
        load.refuse("VALUE_NOT_IN_RANGE", extension.at("count"), "is 0, must be at least 1");
    requireMode(load, extension, stream);
    requireFilter(load, extension, stream);
    const uint64_t length = view.requiredInteger("byteLength");
    if (length / stream.stride != stream.count || length % stream.stride != 0)
        load.refuse("VALUE_NOT_IN_RANGE", view.at("byteLength"),
                    "is " + std::to_string(length) + ", must be the " +
                        std::to_string(stream.count) + " times " + std::to_string(stream.stride) +
                        " bytes that are compressed");
    if (view.integer("byteStride", stream.stride) != stream.stride)
        load.refuse("VALUE_NOT_IN_LIST", view.at("byteStride"),
                    "differs from that of the compressed data, " + std::to_string(stream.stride));
    stream.bytes = bufferBytes(load, extension);
    if (length / kLargestRatio > stream.bytes.size())
        load.refuse("COMPRESSED_DATA_INVALID", extension.at("byteLength"),
                    "is " + std::to_string(stream.bytes.size()) + ", too little for " +
                        std::to_string(length) + " bytes");
    return stream;
}

/// What is wrong with the stream; empty: nothing.
std::string decode(const Stream& stream, Bytes& out)
{
    const auto* source = reinterpret_cast<const unsigned char*>(stream.bytes.data());
    const size_t size = stream.bytes.size();
    int result = 0;
    if (stream.mode == "TRIANGLES")
        result = meshopt_decodeIndexBuffer(out.data(), stream.count, stream.stride, source, size);
    else if (stream.mode == "INDICES")
        result = meshopt_decodeIndexSequence(out.data(), stream.count, stream.stride, source, size);
    else
        result = meshopt_decodeVertexBuffer(out.data(), stream.count, stream.stride, source, size);
    if (result == -1)  // the head of the stream names kind and version
        return "is not of this mode, or of a version that this build's meshoptimizer does not know";
    if (result != 0) return "cannot be decoded: it is damaged or cut off";
    if (stream.filter == "OCTAHEDRAL")
        meshopt_decodeFilterOct(out.data(), stream.count, stream.stride);
    else if (stream.filter == "QUATERNION")
        meshopt_decodeFilterQuat(out.data(), stream.count, stream.stride);
    else if (stream.filter == "EXPONENTIAL")
        meshopt_decodeFilterExp(out.data(), stream.count, stream.stride);
    return {};
}

}  // namespace

std::optional<Object> meshoptOf(const Object& view)
{
    const std::optional<Json> extensions = view.find("extensions");
    if (!extensions) return std::nullopt;
    for (const char* name : {"EXT_meshopt_compression", "KHR_meshopt_compression"})
        if (const std::optional<Json> found = extensions->find(name))
            return Object(view.load(), *found, child(view.at("extensions"), name));
    return std::nullopt;
}

std::vector<bool> fallbackBuffers(Load& load)
{
    const size_t count = countOf(load, "buffers");
    std::vector<bool> replaced(count, false), needed(count, false);
    const auto refer = [&](const Object& from, std::vector<bool>& list) {
        const int buffer = from.index("buffer", count, "buffer");
        if (buffer >= 0) list[static_cast<size_t>(buffer)] = true;
    };
    for (size_t i = 0; i < countOf(load, "bufferViews"); ++i) {
        const Object view = topLevel(load, "bufferViews", i);
        const std::optional<Object> extension = meshoptOf(view);
        refer(view, extension ? replaced : needed);
        if (extension) refer(*extension, needed);
    }
    for (size_t i = 0; i < count; ++i) replaced[i] = replaced[i] && !needed[i];
    return replaced;
}

void decodeViews(Load& load)
{
    const size_t count = countOf(load, "bufferViews");
    for (size_t i = 0; i < count; ++i) {
        const Object view = topLevel(load, "bufferViews", i);
        const std::optional<Object> extension = meshoptOf(view);
        if (!extension) continue;
        load.stage("decoding", static_cast<double>(i) / static_cast<double>(count));
        view.requiredIndex("buffer", load.buffers.size(), "buffer");
        const Stream stream = readStream(load, view, *extension);
        load.reserveMemory(stream.stride * stream.count, extension->pointer());
        Bytes out(stream.stride * stream.count);
        if (const std::string problem = decode(stream, out); !problem.empty())
            load.refuse("COMPRESSED_DATA_INVALID", extension->pointer(), problem);
        load.decodedViews.emplace(i, std::move(out));
    }
}

}  // namespace core::gltf
