// See draco_mesh.h. The only file that sees Draco.
//
// Draco's own entry, draco::Decoder, takes memory for any number of triangles, points or attributes
// that a stream names (its issue 1169: 61 bytes ask for gigabytes). So its two decoders of meshes
// are derived from here, and what they are about to do is judged between their steps. It checks
// what it reads against the end of the stream and returns a status; what it gets wrong nobody here
// can mend, but the parts that were found faulty most often are out of reach: those of point clouds
// and of old bitstreams, both refused by the head of a stream.
#include "core/gltf/draco_mesh.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>
#include <stdexcept>

#include <draco/compression/config/decoder_options.h>
#include <draco/compression/mesh/mesh_edgebreaker_decoder.h>
#include <draco/compression/mesh/mesh_sequential_decoder.h>
#include <draco/core/varint_decoding.h>

#include "core/gltf/accessors.h"

namespace core::gltf {

namespace {

/// What the decoder holds per triangle: its three corners' vertices, opposite corners and points,
/// the order of traversal; and per further set of attributes three more numbers.
constexpr uint64_t kFaceBytes = 80, kFaceBytesPerSet = 16, kVertexBytes = 24, kPointBytes = 16;

/// Reads numbers ahead of the decoder, which stays where it is.
class Ahead {
public:
    explicit Ahead(const draco::DecoderBuffer& buffer) : buffer_(buffer) {}
    uint64_t varint()
    {
        uint32_t value = 0;
        fine_ = fine_ && draco::DecodeVarint(&value, &buffer_);
        return value;
    }
    uint64_t byte()
    {
        uint8_t value = 0;
        fine_ = fine_ && buffer_.Decode(&value);
        return value;
    }
    bool fine() const { return fine_; }

private:
    draco::DecoderBuffer buffer_;
    bool fine_ = true;
};

/// The head of a stream of the edgebreaker method; nothing when it is cut off.
std::optional<DracoSizes> connectivity(const draco::MeshEdgebreakerDecoder&, Ahead ahead)
{
    const uint64_t vertices = ahead.varint(), faces = ahead.varint(), sets = ahead.byte();
    ahead.varint();  // symbols
    const uint64_t splits = ahead.varint();
    if (!ahead.fine()) return std::nullopt;
    return DracoSizes{faces, 0,
                      faces * (kFaceBytes + sets * kFaceBytesPerSet) +
                          (vertices + splits) * kVertexBytes};
}

/// That of a stream of the sequential method.
std::optional<DracoSizes> connectivity(const draco::MeshSequentialDecoder&, Ahead ahead)
{
    const uint64_t faces = ahead.varint(), points = ahead.varint();
    if (!ahead.fine()) return std::nullopt;
    return DracoSizes{faces, points, faces * kFaceBytes + points * kVertexBytes};
}

/// One of Draco's decoders, watched.
template <class Decoder> class Guarded : public Decoder {
public:
    explicit Guarded(const DracoGuard& guard) : guard_(guard) {}

protected:
    bool DecodeConnectivity() override
    {
        const std::optional<DracoSizes> sizes = connectivity(*this, Ahead(*this->buffer()));
        if (!sizes || sizes->faces == 0) return false;
        guard_(*sizes);
        return Decoder::DecodeConnectivity();
    }

    /// All attributes are described by now, and none has values.
    bool DecodeAllAttributes() override
    {
        const draco::Mesh& mesh = *this->mesh();
        const uint64_t points = mesh.num_points();
        uint64_t each = kPointBytes;
        for (int i = 0; i < mesh.num_attributes(); ++i) {
            const draco::PointAttribute& attribute = *mesh.attribute(i);
            const auto components = static_cast<uint64_t>(attribute.num_components());
            // Draco counts values in 32 bits.
            constexpr uint64_t kMostValues = std::numeric_limits<int32_t>::max();
            if (components == 0 || points > kMostValues / components) return false;
            // Final values, quantised ones, and the map from points to them.
            each += static_cast<uint64_t>(attribute.byte_stride()) + 4 * components + kPointBytes;
        }
        guard_({mesh.num_faces(), points, points * each});
        return Decoder::DecodeAllAttributes();
    }

private:
    const DracoGuard& guard_;
};

template <class Decoder>
draco::Status decodeWith(draco::DecoderBuffer& buffer, draco::Mesh& mesh, const DracoGuard& guard)
{
    Guarded<Decoder> decoder(guard);
    return decoder.Decode(draco::DecoderOptions(), &buffer, &mesh);
}

/// Fills `mesh`; returns what is wrong with the stream, empty for nothing.
std::string decode(draco::DecoderBuffer& buffer, draco::Mesh& mesh, const DracoGuard& guard)
{
    draco::DracoHeader head;
    draco::DecoderBuffer copy(buffer);
    if (!draco::PointCloudDecoder::DecodeHeader(&copy, &head).ok()) return "is no Draco stream";
    if (head.encoder_type != draco::TRIANGULAR_MESH) return "holds a point cloud, must hold a mesh";
    if (head.version_major != 2 || head.version_minor != 2)
        return "is of version " + std::to_string(head.version_major) + '.' +
               std::to_string(head.version_minor) + " of Draco's format, glTF has 2.2";
    draco::Status status(draco::Status::DRACO_ERROR, "unknown method");
    if (head.encoder_method == draco::MESH_EDGEBREAKER_ENCODING)
        status = decodeWith<draco::MeshEdgebreakerDecoder>(buffer, mesh, guard);
    else if (head.encoder_method == draco::MESH_SEQUENTIAL_ENCODING)
        status = decodeWith<draco::MeshSequentialDecoder>(buffer, mesh, guard);
    if (!status.ok())
        return "cannot be decoded: it is damaged or cut off (" + status.error_msg_string() + ')';
    return mesh.num_faces() == 0 || mesh.num_points() == 0 ? "holds no triangles" : "";
}

uint32_t componentTypeOf(draco::DataType type)
{
    switch (type) {
    case draco::DT_INT8:
        return kByte;
    case draco::DT_UINT8:
        return kUnsignedByte;
    case draco::DT_INT16:
        return kShort;
    case draco::DT_UINT16:
        return kUnsignedShort;
    case draco::DT_UINT32:
        return kUnsignedInt;
    case draco::DT_FLOAT32:
        return kFloat;
    default:
        return 0;
    }
}

/// False when a triangle has a vertex that is not there.
bool copyIndices(const draco::Mesh& mesh, std::vector<uint32_t>& out)
{
    out.reserve(size_t{3} * mesh.num_faces());
    for (uint32_t i = 0; i < mesh.num_faces(); ++i)
        for (const draco::PointIndex& point : mesh.face(draco::FaceIndex(i))) {
            if (point.value() >= mesh.num_points()) return false;
            out.push_back(point.value());
        }
    return true;
}

/// False when a point has a value that is not there.
bool copyValues(const draco::PointAttribute& source, uint32_t points, DracoAttribute& out)
{
    out.found = true;
    out.componentType = componentTypeOf(source.data_type());
    out.components = static_cast<uint32_t>(source.num_components());
    out.normalized = source.normalized();
    if (out.componentType == 0) return true;
    if (!source.is_mapping_identity() && source.indices_map_size() < points) return false;
    const size_t size =
        size_t{out.components} * static_cast<size_t>(draco::DataTypeLength(source.data_type()));
    const auto stride = static_cast<size_t>(source.byte_stride()),
               offset = static_cast<size_t>(source.byte_offset()),
               available = source.buffer() ? source.buffer()->data_size() : 0;
    out.values.resize(size * points);
    for (uint32_t i = 0; i < points; ++i) {
        const size_t value = source.mapped_index(draco::PointIndex(i)).value();
        if (value >= source.size() || offset + value * stride + size > available) return false;
        std::memcpy(out.values.data() + i * size, source.buffer()->data() + offset + value * stride,
                    size);
    }
    return true;
}

}  // namespace

DracoMesh decodeDraco(std::span<const std::byte> bytes, std::span<const uint32_t> ids,
                      const DracoGuard& guard)
{
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::Mesh mesh;
    DracoMesh result;
    try {
        result.problem = decode(buffer, mesh, guard);
    } catch (const std::logic_error&) {  // of the standard library; Draco itself throws nothing
        result.problem = "asks for more values than an array can have";
    }
    if (!result.problem.empty()) return result;
    result.points = mesh.num_points();
    result.attributes.resize(ids.size());
    bool whole = copyIndices(mesh, result.indices);
    for (size_t i = 0; i < ids.size() && whole; ++i)
        if (const draco::PointAttribute* attribute = mesh.GetAttributeByUniqueId(ids[i]))
            whole = copyValues(*attribute, mesh.num_points(), result.attributes[i]);
    if (!whole) result.problem = "refers to values that it does not have";
    return result;
}

}  // namespace core::gltf
