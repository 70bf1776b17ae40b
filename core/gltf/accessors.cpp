// Buffers, buffer views and accessors.
#include "core/gltf/accessors.h"

#include <algorithm>
#include <cstring>
#include <map>
#include <ranges>
#include <string_view>

#include "core/gltf/compression.h"
#include "core/gltf/guard.h"

namespace core::gltf {

namespace {

uint32_t componentBytes(uint64_t type)
{
    switch (type) {
    case kByte:
    case kUnsignedByte:
        return 1;
    case kShort:
    case kUnsignedShort:
        return 2;
    case kUnsignedInt:
    case kFloat:
        return 4;
    default:
        return 0;
    }
}

uint32_t componentsOf(std::string_view type)
{
    if (type == "SCALAR") return 1;
    if (type == "VEC2") return 2;
    if (type == "VEC3") return 3;
    if (type == "VEC4" || type == "MAT2") return 4;
    if (type == "MAT3") return 9;
    if (type == "MAT4") return 16;
    return 0;
}

struct BufferView {
    std::span<const std::byte> bytes;
    uint64_t stride = 0;
};

BufferView resolveView(Load& load, size_t index)
{
    const Object view = topLevel(load, "bufferViews", index);
    const auto decoded = load.decodedViews.find(index);
    const std::span<const std::byte> bytes =
        decoded == load.decodedViews.end() ? bufferBytes(load, view) : decoded->second;
    BufferView result{bytes, view.integer("byteStride", 0)};
    if (view.has("byteStride") && (result.stride < 4 || result.stride > 252))
        load.refuse("VALUE_NOT_IN_RANGE", view.at("byteStride"),
                    "is " + std::to_string(result.stride) + ", must be in [4, 252]");
    return result;
}

/// Refuses unless `count` elements of `size` bytes, `stride` apart, fit into the view from `offset`
/// on.
void requireExtent(Load& load, const std::string& pointer, const BufferView& view, int viewIndex,
                   uint64_t offset, uint64_t count, uint64_t size, uint64_t stride)
{
    const uint64_t available = view.bytes.size();
    // (count - 1) * stride + size without overflow: the stride is at least 1, so count is bounded
    // first.
    const bool fits = offset <= available && count <= available + 1 &&
                      (count - 1) * stride + size <= available - offset;
    if (fits) return;
    const std::string needed = count <= (uint64_t{1} << 40)
                                   ? std::to_string((count - 1) * stride + size)
                                   : std::to_string(count) + " elements of " + std::to_string(size);
    load.refuse("ACCESSOR_TOO_LONG", pointer,
                "needs " + needed + " bytes at offset " + std::to_string(offset) + ", bufferView " +
                    std::to_string(viewIndex) + " has " + std::to_string(available));
}

uint64_t readIndex(const std::byte* data, uint32_t type, uint64_t i)
{
    switch (type) {
    case kUnsignedByte:
        return static_cast<uint64_t>(data[i]);
    case kUnsignedShort: {
        uint16_t value = 0;
        std::memcpy(&value, data + 2 * i, 2);
        return value;
    }
    default: {
        uint32_t value = 0;
        std::memcpy(&value, data + 4 * i, 4);
        return value;
    }
    }
}

void readSparse(Load& load, const Object& sparse, Accessor& accessor)
{
    const size_t viewCount = countOf(load, "bufferViews");
    accessor.sparseCount = sparse.requiredInteger("count");
    if (accessor.sparseCount == 0 || accessor.sparseCount > accessor.count)
        load.refuse("ACCESSOR_SPARSE_COUNT_OUT_OF_RANGE", sparse.at("count"),
                    "is " + std::to_string(accessor.sparseCount) + ", must be in [1, " +
                        std::to_string(accessor.count) + "]");
    const std::optional<Object> indices = sparse.object("indices"),
                                values = sparse.object("values");
    if (!indices || !values)
        load.refuse("UNDEFINED_PROPERTY", sparse.pointer(), "'indices' or 'values' is missing");

    const int indexView = indices->requiredIndex("bufferView", viewCount, "bufferView");
    const uint64_t type = indices->requiredInteger("componentType");
    if (type != kUnsignedByte && type != kUnsignedShort && type != kUnsignedInt)
        load.refuse("VALUE_NOT_IN_LIST", indices->at("componentType"),
                    "is " + std::to_string(type) + ", must be an unsigned integer type");
    accessor.sparseType = static_cast<uint32_t>(type);
    const BufferView indexBytes = resolveView(load, static_cast<size_t>(indexView));
    const uint64_t indexOffset = indices->integer("byteOffset", 0);
    const uint32_t indexSize = componentBytes(type);
    requireExtent(load, indices->pointer(), indexBytes, indexView, indexOffset,
                  accessor.sparseCount, indexSize, indexSize);
    accessor.sparseIndices = indexBytes.bytes.data() + indexOffset;

    const int valueView = values->requiredIndex("bufferView", viewCount, "bufferView");
    const BufferView valueBytes = resolveView(load, static_cast<size_t>(valueView));
    const uint64_t valueOffset = values->integer("byteOffset", 0);
    requireExtent(load, values->pointer(), valueBytes, valueView, valueOffset, accessor.sparseCount,
                  accessor.elementBytes(), accessor.elementBytes());
    accessor.sparseValues = valueBytes.bytes.data() + valueOffset;

    for (uint64_t i = 0; i < accessor.sparseCount; ++i) {
        const uint64_t at = readIndex(accessor.sparseIndices, accessor.sparseType, i);
        if (at >= accessor.count)
            load.refuse("ACCESSOR_SPARSE_INDEX_OOB", indices->pointer(),
                        "index " + std::to_string(i) + " is " + std::to_string(at) +
                            ", the accessor has " + std::to_string(accessor.count) + " elements");
        if (i > 0 && at <= readIndex(accessor.sparseIndices, accessor.sparseType, i - 1))
            load.refuse("ACCESSOR_SPARSE_INDICES_NON_INCREASING", indices->pointer(),
                        "index " + std::to_string(i) + " (" + std::to_string(at) +
                            ") does not increase");
    }
}

Accessor readAccessor(Load& load, const Object& object)
{
    Accessor accessor;
    const uint64_t type = object.requiredInteger("componentType");
    const uint32_t size = componentBytes(type);
    if (size == 0) {
        accessor.problemAt = object.at("componentType");
        accessor.problem =
            "is " + std::to_string(type) + ", must be one of 5120, 5121, 5122, 5123, 5125, 5126";
        return accessor;
    }
    accessor.componentType = static_cast<uint32_t>(type);
    const std::string shape = object.requiredString("type");
    accessor.components = componentsOf(shape);
    accessor.matrix = shape.starts_with("MAT");
    if (accessor.components == 0) {
        accessor.problemAt = object.at("type");
        accessor.problem = "is " + describe(shape) + ", must be SCALAR, VEC2..4 or MAT2..4";
        return accessor;
    }
    accessor.normalized = object.boolean("normalized", false);
    accessor.count = object.requiredInteger("count");
    if (accessor.count == 0)
        load.refuse("VALUE_NOT_IN_RANGE", object.at("count"), "is 0, must be at least 1");

    const int viewIndex = object.index("bufferView", countOf(load, "bufferViews"), "bufferView");
    const uint64_t offset = object.integer("byteOffset", 0);
    if (viewIndex >= 0) {
        const BufferView view = resolveView(load, static_cast<size_t>(viewIndex));
        const uint64_t stride = view.stride ? view.stride : accessor.elementBytes();
        if (stride < accessor.elementBytes())
            load.refuse("ACCESSOR_SMALL_BYTESTRIDE", object.pointer(),
                        "has elements of " + std::to_string(accessor.elementBytes()) +
                            " bytes, bufferView " + std::to_string(viewIndex) + " a stride of " +
                            std::to_string(stride));
        requireExtent(load, object.pointer(), view, viewIndex, offset, accessor.count,
                      accessor.elementBytes(), stride);
        accessor.data = view.bytes.data() + offset;
        accessor.stride = stride;
    } else {
        // Zeros cost no bytes in the file: bound them by what the file brought, as with compressed
        // images.
        const uint64_t allowed = 1000 * load.scene.fileBytes + (16u << 20);
        if (accessor.count > allowed / accessor.elementBytes())
            load.refuse("ACCESSOR_TOO_LONG", object.pointer(),
                        "has " + std::to_string(accessor.count) + " elements and no bufferView");
    }
    if (const std::optional<Object> sparse = object.object("sparse"))
        readSparse(load, *sparse, accessor);
    return accessor;
}

/// Component `k` of the element at `p`.
template <class T, bool normalized> float component(const std::byte* p, uint32_t k)
{
    T value{};
    std::memcpy(&value, p + k * sizeof(T), sizeof(T));
    const auto number = static_cast<float>(value);
    if constexpr (!normalized) return number;
    constexpr auto largest = static_cast<float>(std::numeric_limits<T>::max());
    return std::max(number / largest, -1.0f);
}

template <class T, bool normalized>
void convert(const std::byte* data, size_t stride, uint64_t count, uint32_t components, float* out)
{
    for (uint64_t i = 0; i < count; ++i, data += stride)
        for (uint32_t k = 0; k < components; ++k) *out++ = component<T, normalized>(data, k);
}

void convert(const Accessor& accessor, const std::byte* data, size_t stride, uint64_t count,
             uint32_t components, float* out)
{
    const bool normalized = accessor.normalized;
    switch (accessor.componentType) {
    case kByte:
        return normalized ? convert<int8_t, true>(data, stride, count, components, out)
                          : convert<int8_t, false>(data, stride, count, components, out);
    case kUnsignedByte:
        return normalized ? convert<uint8_t, true>(data, stride, count, components, out)
                          : convert<uint8_t, false>(data, stride, count, components, out);
    case kShort:
        return normalized ? convert<int16_t, true>(data, stride, count, components, out)
                          : convert<int16_t, false>(data, stride, count, components, out);
    case kUnsignedShort:
        return normalized ? convert<uint16_t, true>(data, stride, count, components, out)
                          : convert<uint16_t, false>(data, stride, count, components, out);
    case kUnsignedInt:
        return convert<uint32_t, false>(data, stride, count, components, out);
    default:
        return convert<float, false>(data, stride, count, components, out);
    }
}

/// The first sparse entry whose index is at least `index`: readSparse has made sure that they
/// ascend. Many readers of few elements each would otherwise walk all entries every time.
uint64_t firstSparse(const Accessor& accessor, uint64_t index)
{
    const auto entries = std::views::iota(uint64_t{0}, accessor.sparseCount);
    const auto found = std::ranges::lower_bound(entries, index, {}, [&](uint64_t i) {
        return readIndex(accessor.sparseIndices, accessor.sparseType, i);
    });
    return static_cast<uint64_t>(found - entries.begin());
}

/// By URI.
using Read = std::map<std::string, std::span<const std::byte>>;

}  // namespace

uint32_t Accessor::elementBytes() const
{
    return components * componentBytes(componentType);
}

/// The bytes of a buffer's URI, read once however many buffers name it.
static std::span<const std::byte> bufferFile(Load& load, const Object& buffer, Read& read)
{
    const std::string uri = buffer.requiredString("uri");
    const auto [known, isNew] = read.try_emplace(uri);
    if (!isNew) return known->second;
    Content content = readUri(load, uri);
    if (!content.problem.empty())
        load.refuse("IO_ERROR", buffer.at("uri"), "missing buffer file: " + content.problem);
    load.reserveMemory(content.bytes.size(), buffer.at("uri"));
    load.hash.add(content.bytes);
    load.scene.fileBytes += content.bytes.size();
    load.storage.push_back(std::move(content.bytes));
    return known->second = load.storage.back();
}

void readBuffers(Load& load)
{
    Read read;
    const std::vector<bool> isFallback = fallbackBuffers(load);
    const size_t count = countOf(load, "buffers");
    for (size_t i = 0; i < count; ++i) {
        load.stage("reading", static_cast<double>(i) / static_cast<double>(count));
        const Object buffer = topLevel(load, "buffers", i);
        const uint64_t length = buffer.requiredInteger("byteLength");
        if (length == 0)
            load.refuse("VALUE_NOT_IN_RANGE", buffer.at("byteLength"), "is 0, must be at least 1");
        std::span<const std::byte> bytes;
        if (isFallback[i]) {
            load.buffers.emplace_back();
            continue;
        }
        if (buffer.has("uri")) {
            bytes = bufferFile(load, buffer, read);
        } else if (i == 0 && !load.binaryChunk.empty()) {
            bytes = load.binaryChunk;
        } else {  // allowed as long as no view refers to it
            load.buffers.emplace_back();
            continue;
        }
        if (length > bytes.size())
            load.refuse("BUFFER_BYTE_LENGTH_MISMATCH", buffer.at("byteLength"),
                        "is " + std::to_string(length) + ", the data has " +
                            std::to_string(bytes.size()) + " bytes");
        load.buffers.push_back(bytes.first(length));
    }
}

std::span<const std::byte> bufferBytes(Load& load, const Object& place)
{
    const auto buffer =
        static_cast<size_t>(place.requiredIndex("buffer", load.buffers.size(), "buffer"));
    if (load.buffers[buffer].empty())
        load.refuse("UNDEFINED_PROPERTY", child("/buffers", buffer),
                    "has neither a 'uri' nor the binary chunk of a GLB");
    const uint64_t offset = place.integer("byteOffset", 0),
                   length = place.requiredInteger("byteLength");
    const uint64_t available = load.buffers[buffer].size();
    if (length == 0)
        load.refuse("VALUE_NOT_IN_RANGE", place.at("byteLength"), "is 0, must be at least 1");
    if (offset > available || length > available - offset)
        load.refuse("BUFFER_VIEW_TOO_LONG", place.pointer(),
                    "needs " + std::to_string(length) + " bytes at offset " +
                        std::to_string(offset) + ", buffer " + std::to_string(buffer) + " has " +
                        std::to_string(available));
    return load.buffers[buffer].subspan(offset, length);
}

std::span<const std::byte> bufferViewBytes(Load& load, size_t index)
{
    return resolveView(load, index).bytes;
}

std::vector<Accessor> readAccessors(Load& load)
{
    for (size_t i = 0; i < countOf(load, "bufferViews"); ++i) resolveView(load, i);
    std::vector<Accessor> accessors;
    const size_t count = countOf(load, "accessors");
    accessors.reserve(count);
    for (size_t i = 0; i < count; ++i)
        accessors.push_back(readAccessor(load, topLevel(load, "accessors", i)));
    return accessors;
}

const Accessor& usable(const Load& load, const std::vector<Accessor>& accessors, int index)
{
    const Accessor& accessor = accessors[static_cast<size_t>(index)];
    if (!accessor.problem.empty())
        load.refuse("VALUE_NOT_IN_LIST", accessor.problemAt, accessor.problem);
    return accessor;
}

void readFloats(const Accessor& accessor, uint64_t first, uint64_t count, uint32_t components,
                float* out)
{
    if (!accessor.data) {
        std::fill_n(out, count * components, 0.0f);
    } else if (accessor.isFloat() && components == accessor.components &&
               accessor.stride == accessor.elementBytes()) {
        std::memcpy(out, accessor.data + first * accessor.stride, count * accessor.stride);
    } else {
        convert(accessor, accessor.data + first * accessor.stride, accessor.stride, count,
                components, out);
    }
    const uint32_t size = accessor.elementBytes();
    for (uint64_t i = firstSparse(accessor, first); i < accessor.sparseCount; ++i) {
        const uint64_t at = readIndex(accessor.sparseIndices, accessor.sparseType, i);
        if (at >= first + count) break;
        convert(accessor, accessor.sparseValues + i * size, size, 1, components,
                out + (at - first) * components);
    }
}

uint32_t restartIndex(const Accessor& accessor)
{
    return accessor.componentType == kUnsignedByte    ? 0xffu
           : accessor.componentType == kUnsignedShort ? 0xffffu
                                                      : 0xffffffffu;
}

std::vector<uint32_t> readIndices(const Accessor& accessor)
{
    std::vector<uint32_t> result(accessor.count);
    const auto read = [&]<class T>(T) {
        for (uint64_t i = 0; i < accessor.count; ++i) {
            T value{};
            std::memcpy(&value, accessor.data + i * accessor.stride, sizeof(T));
            result[i] = value;
        }
    };
    if (accessor.data) {
        if (accessor.componentType == kUnsignedByte)
            read(uint8_t{});
        else if (accessor.componentType == kUnsignedShort)
            read(uint16_t{});
        else
            read(uint32_t{});
    }
    for (uint64_t i = 0; i < accessor.sparseCount; ++i)
        result[readIndex(accessor.sparseIndices, accessor.sparseType, i)] =
            static_cast<uint32_t>(readIndex(accessor.sparseValues, accessor.componentType, i));
    return result;
}

}  // namespace core::gltf
