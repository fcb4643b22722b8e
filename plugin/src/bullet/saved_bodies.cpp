// SPDX-License-Identifier: Zlib

// This file saves and restores the state of whole systems, copies bodies, and writes them with their networks
// to files, Bullet's included.

#include "bullet/body_in_world.h"
#include "bullet/system_impl.h"
#include "mesh/bytes.h"

#include <LinearMath/btSerializer.h>

#include <cstring>
#include <type_traits>

namespace limber {

// what ByteReader needs to know of the settings' types
static constexpr SpringAction lastOf(SpringAction) { return SpringAction::CompressionOnly; }

inline namespace LIMBER_BULLET_PRECISION {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr SealedFormat kSystemFormat = {
    {0x89, 'L', 'I', 'M', 'S', 'Y', '\r', '\n'}, "a saved state of a system", "the saved state", 4, 4};
constexpr SealedFormat kBodiesFormat = {
    {0x89, 'L', 'I', 'M', 'B', 'D', '\r', '\n'}, "a file of soft bodies", "the file", 2, 2};

// --- systems -----------------------------------------------------------------------------------------------

struct SpringState {
  SpringSettings settings;  ///< with a rest length
  bool broken = false;
  double force = 0.0;                                  ///< N, in the last tick
  Eigen::Vector3d worldEnd = Eigen::Vector3d::Zero();  ///< m, of an end that is fixed in the world
};

template <class Stream, class Spring>
void transferSpring(Stream& stream, Spring& spring) {
  auto& s = spring.settings;
  double restLength = s.restLength.value_or(0.0);
  stream.value("restLength", restLength);
  stream.value("stiffness", s.stiffness);
  stream.value("damping", s.damping);
  stream.value("breakForce", s.breakForce);
  stream.value("action", s.action);
  std::uint8_t broken = spring.broken;
  stream.value("broken", broken);
  stream.value("force", spring.force);
  for (Eigen::Index i = 0; i < 3; ++i) stream.value("place of a spring's end", spring.worldEnd[i]);
  if constexpr (!std::is_const_v<Spring>) {
    s.restLength = restLength;
    spring.broken = broken != 0;
  }
}

/// The state of a system: of its bodies and single springs, in order of creation.
struct SystemState {
  double time = 0.0;  ///< s, of wind and fields
  std::vector<Bytes> bodies;
  std::vector<SpringState> springs;  ///< without those of grabs
};

template <class Stream, class State>
void transferSystem(Stream& stream, State& state) {
  stream.value("time", state.time);
  stream.resize("bodies", state.bodies, sizeof(std::uint64_t));
  for (auto& body : state.bodies) stream.array("bytes of a body", body);
  stream.resize("springs", state.springs, 8 * sizeof(double));
  for (auto& spring : state.springs) transferSpring(stream, spring);
}

/// Returns why a spring's state is not valid, or an empty string.
std::string checkSpring(const SpringState& spring) {
  if (Result<void> valid = validate(spring.settings); !valid) return valid.error();
  if (!(std::abs(spring.force) <= kMaxSound)) return "its force is not finite";
  if (!(spring.worldEnd.squaredNorm() <= 1e12)) return "its end is not finite, or farther than 1e6 m";
  return {};
}

/// Returns why a state does not suit a system, or an empty string.
std::string checkCount(const char* what, std::size_t saved, std::size_t present) {
  if (saved == present) return {};
  return "the saved state has " + std::to_string(saved) + " " + what + ", the system " +
         std::to_string(present);
}

}  // namespace

std::vector<SpringConstraint*> SoftBodySystem::Impl::savedSprings() const {
  std::vector<SpringConstraint*> saved;
  for (const auto& spring : this->springs)
    if (!spring->grab_) saved.push_back(spring.get());
  return saved;
}

Bytes SoftBodySystem::saveState() {
  SystemState state;
  state.time = impl_->surroundings.time;
  for (const auto& body : impl_->bodies) state.bodies.push_back(saveStateOf(*body->data_));
  for (const SpringConstraint* spring : impl_->savedSprings()) {
    SpringState saved{spring->settings(), spring->broken(), spring->force(), Eigen::Vector3d::Zero()};
    for (const SpringEnd* end : {&spring->a_, &spring->b_})
      if (!end->body) saved.worldEnd = toEigen(end->pivot);
    state.springs.push_back(saved);
  }
  return sealedBytes(kSystemFormat,
                     [&](ByteWriter& writer) { transferSystem(writer, std::as_const(state)); });
}

Result<void> SoftBodySystem::restoreState(const Bytes& bytes) {
  SystemState state;
  const auto transfer = [](ByteReader& reader, SystemState& s) { transferSystem(reader, s); };
  if (std::string reason = readSealed(kSystemFormat, bytes.data(), bytes.size(), state, transfer);
      !reason.empty())
    return Error{std::move(reason)};
  std::string reason = checkCount("bodies", state.bodies.size(), impl_->bodies.size());
  const std::vector<SpringConstraint*> springs = impl_->savedSprings();
  if (reason.empty()) reason = checkCount("springs", state.springs.size(), springs.size());
  for (std::size_t i = 0; i < state.springs.size() && reason.empty(); ++i)
    if (std::string why = checkSpring(state.springs[i]); !why.empty())
      reason = "spring " + std::to_string(i) + ": " + why;
  for (std::size_t i = 0; i < state.bodies.size() && reason.empty(); ++i)
    if (Result<void> valid = checkStateFor(*impl_->bodies[i]->data_, state.bodies[i]); !valid)
      reason = "body " + std::to_string(i) + ": " + valid.error();
  if (reason.empty() && !(std::abs(state.time) <= kMaxSound)) reason = "its time is not finite";
  if (!reason.empty()) return Error{std::move(reason)};
  for (std::size_t i = 0; i < state.bodies.size(); ++i) {
    const Result<void> restored = restoreStateOf(*impl_->bodies[i]->data_, state.bodies[i]);
    if (!restored) return Error{"body " + std::to_string(i) + ": " + restored.error()};
  }
  impl_->surroundings.time = state.time;
  for (std::size_t i = 0; i < state.springs.size(); ++i) {
    springs[i]->settings_ = state.springs[i].settings;
    springs[i]->broken_ = state.springs[i].broken;
    springs[i]->force_ = state.springs[i].force;
    springs[i]->target_.reset();
    for (SpringEnd* end : {&springs[i]->a_, &springs[i]->b_})
      if (!end->body) end->pivot = toBullet(state.springs[i].worldEnd);
  }
  impl_->step->groupsStale = true;
  return {};
}

Result<SoftBody*> SoftBodySystem::clone(SoftBody* body, const btTransform& transform) {
  if (!impl_->step->owns(body)) return Error{"the soft body is not, or no longer, in this world"};
  if (!body->alive()) return notAlive();
  const Bytes state = body->saveState();
  Result<SoftBody*> copy = createBody(body->sharedNetwork(), body->settings());
  if (!copy) return copy;
  Result<void> done = restoreStateOf(*(*copy)->data_, state);
  if (done) done = (*copy)->setTransform(transform);
  if (done) {
    (*copy)->data_->report = ContactReport();  // the original's, elsewhere
    return copy;
  }
  destroyBody(*copy);
  return Error{done.error()};
}

// --- bodies with their networks ----------------------------------------------------------------------------

namespace {

/// Everything of a body, to create it in another world.
struct WholeBody {
  Bytes network, state;
  std::string name;
};

template <class Stream, class Bodies>
void transferBodies(Stream& stream, Bodies& bodies) {
  stream.resize("bodies", bodies, 3 * sizeof(std::uint64_t));
  for (auto& body : bodies) {
    stream.array("bytes of a network", body.network);
    stream.array("bytes of a state", body.state);
    stream.array("letters of a name", body.name);
  }
}

Bytes bytesOf(const std::vector<WholeBody>& bodies) {
  return sealedBytes(kBodiesFormat, [&](ByteWriter& writer) { transferBodies(writer, bodies); });
}

WholeBody wholeBodyOf(SoftBodyData& body) {
  return {toBytes(*body.model->network), saveStateOf(body), body.name};
}

/// The codes of chunks of soft bodies in Bullet's files and of their last chunk, and the start of such a
/// file: "BULLETf" or "BULLETd",
/// '-' for 8-byte pointers, 'v' for little-endian numbers.
constexpr char kChunkCode[] = {'L', 'I', 'M', 'B'}, kLastChunk[] = {'D', 'N', 'A', '1'},
               kBulletFile[] = {'B', 'U', 'L', 'L', 'E', 'T'};
constexpr std::size_t kBulletHeader = 12;

/// Adds the contents of the chunks of soft bodies. A chunk has a header of its code, length, pointer, type
/// and number. Returns whether the last chunk of the file is there.
bool addChunks(const Bytes& file, std::vector<Bytes>& chunks) {
  const std::size_t pointer = file[7] == '-' ? 8 : 4, header = 16 + pointer;
  for (std::size_t at = kBulletHeader; at + header <= file.size();) {
    const std::size_t length = readLittleEndian<std::uint32_t>(&file[at + 4]);
    if (length > file.size() - at - header) return false;
    if (std::equal(kLastChunk, kLastChunk + 4, &file[at])) return true;
    const std::uint8_t* begin = file.data() + at + header;
    if (std::equal(kChunkCode, kChunkCode + 4, &file[at]) && length >= kHeaderBytes)
      // without the padding
      chunks.emplace_back(begin, begin + std::min(length, sealedSize(begin)));
    at += header + length;
  }
  return false;
}

bool isBulletFile(const Bytes& bytes) {
  return bytes.size() >= kBulletHeader &&
         std::equal(std::begin(kBulletFile), std::end(kBulletFile), bytes.begin());
}

/// Adds the bodies in the bytes to `bodies`. Returns why they cannot be read, or an empty string.
std::string readBodies(const Bytes& bytes, std::vector<WholeBody>& bodies) {
  if (isBulletFile(bytes)) {
    if (bytes[8] != 'v') return "the .bullet file has big-endian numbers";
    std::vector<Bytes> chunks;
    if (!addChunks(bytes, chunks)) return "the .bullet file is damaged: it has no end (a chunk DNA1)";
    for (const Bytes& chunk : chunks)
      if (std::string reason = readBodies(chunk, bodies); !reason.empty()) return reason;
    return {};
  }
  std::vector<WholeBody> read;
  const auto transfer = [](ByteReader& reader, std::vector<WholeBody>& all) { transferBodies(reader, all); };
  std::string reason = readSealed(kBodiesFormat, bytes.data(), bytes.size(), read, transfer);
  bodies.insert(bodies.end(), read.begin(), read.end());
  return reason;
}

using Networks = std::map<Bytes, SharedNetwork>;

/// Makes a body at its start. Equal networks are read once.
Result<SoftBody*> makeFrom(SoftBodySystem& system, const WholeBody& saved, Networks& networks) {
  SharedNetwork& network = networks[saved.network];
  if (!network) {
    Result<SharedNetwork> read = fromBytes(saved.network.data(), saved.network.size());
    if (!read) return Error{read.error()};
    network = *read;
  }
  const Result<SoftBodySettings> settings = settingsIn(saved.state);
  if (!settings) return Error{settings.error()};
  return system.createBody(network, *settings);
}

}  // namespace

void writeChunk(SoftBodyData& body, btSerializer& serializer) {
  Bytes bytes = bytesOf({wholeBodyOf(body)});
  // Bullet reads the chunks that follow as numbers of 8 bytes
  bytes.resize((bytes.size() + 7) / 8 * 8);
  btChunk* chunk = serializer.allocate(bytes.size(), 1);
  std::memcpy(chunk->m_oldPtr, bytes.data(), bytes.size());
  int code = 0;
  std::memcpy(&code, kChunkCode, sizeof code);
  serializer.finalizeChunk(chunk, "char", code, &body);
}

Bytes SoftBodySystem::saveBodies() {
  std::vector<WholeBody> bodies;
  for (const auto& body : impl_->bodies)
    if (body->alive()) bodies.push_back(wholeBodyOf(*body->data_));
  return bytesOf(bodies);
}

Result<std::vector<SoftBody*>> SoftBodySystem::loadBodies(const Bytes& bytes) {
  std::vector<WholeBody> bodies;
  if (std::string reason = readBodies(bytes, bodies); !reason.empty()) return Error{std::move(reason)};
  Networks networks;
  std::vector<SoftBody*> made;
  std::string reason;
  const auto failed = [&](std::size_t i, const std::string& why) {
    return "body " + std::to_string(i) + ": " + why;
  };
  for (std::size_t i = 0; i < bodies.size() && reason.empty(); ++i) {
    if (Result<SoftBody*> body = makeFrom(*this, bodies[i], networks))
      made.push_back(*body);
    else
      reason = failed(i, body.error());
  }
  // when all are in the world, because states name the objects that a body touches
  for (std::size_t i = 0; i < bodies.size() && reason.empty(); ++i) {
    made[i]->setName(bodies[i].name);
    if (Result<void> restored = restoreStateOf(*made[i]->data_, bodies[i].state); !restored)
      reason = failed(i, restored.error());
  }
  if (reason.empty()) return made;
  for (SoftBody* body : made) destroyBody(body);
  return Error{std::move(reason)};
}

}  // namespace LIMBER_BULLET_PRECISION
}  // namespace limber
