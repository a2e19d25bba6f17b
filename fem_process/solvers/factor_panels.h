#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <vector>

namespace tandem::fem {

/// Dense panels of a triangular factor in 16 bits per entry, and their products with vectors. An
/// entry is a whole number of −32767 … 32767 times its column's scale: half the memory of single
/// precision, and one conversion instruction on every processor (half-precision floating point
/// would need F16C). Two columns share a 32-bit word.
///
/// The first `columns` rows are lower triangular. Rows go in tiles of 16; a tile holds the column
/// pairs that are not all zero in it, one after the other.
class FactorPanels {
 public:
  static constexpr int kTile = 16;
  struct Panel {
    int columns = 0;
    int rows = 0;           ///< the triangle's included
    std::size_t word = 0;   ///< of its first tile
    std::size_t scale = 0;  ///< of its first column
    [[nodiscard]] int pairs() const { return (columns + 1) / 2; }
    [[nodiscard]] int tiles() const { return (rows + kTile - 1) / kTile; }
    /// Tiles before the first that holds all pairs.
    [[nodiscard]] int triangular() const { return (pairs() + kTile / 2 - 1) / (kTile / 2) - 1; }
    /// Column pairs of a tile.
    [[nodiscard]] int pairs(int tile) const {
      const int triangle = kTile / 2 * (tile + 1);
      return triangle < pairs() ? triangle : pairs();
    }
  };

  /// Appends a panel, rounded.
  Panel add(const Eigen::MatrixXd& values);

  /// x ← x times the columns' scales; one number more is set to zero when the columns are odd.
  void scale(const Panel& panel, const float* x, float* scaled) const;
  /// Rows of P x of the tiles [begin, end): `scaled` is x from scale().
  void multiply(const Panel& panel, const float* scaled, int begin, int end, float* out) const;
  /// Entries of Pᵀ x of the column pairs [begin, end); `begin` is a multiple of kPairs and x has
  /// zeros behind its rows until the end of the last tile.
  void multiply_transposed(const Panel& panel, const float* x, int begin, int end,
                           float* out) const;
  static constexpr int kPairs = 64;

  /// The same for up to eight vectors at once, so that an entry is unpacked once for all of them.
  /// Entry k of vector c of `x`, `scaled` and `out` stands at 8 k + c; of the transposed product's
  /// `tiles` see lay_out_tiles. What is behind the last vector is zero.
  void scale_eight(const Panel& panel, const float* x, float* scaled) const;
  void multiply_eight(const Panel& panel, const float* scaled, int vectors, int begin, int end,
                      float* out) const;
  void multiply_transposed_eight(const Panel& panel, const float* tiles, int vectors, int begin,
                                 int end, float* out) const;
  /// Rows of eight vectors, 8 numbers each, as the transposed product reads them: per tile its 16
  /// rows of the first vector, of the second, … `rows` has whole tiles.
  static void lay_out_tiles(const float* rows, int count, float* tiles);

  [[nodiscard]] std::size_t bytes() const {
    return sizeof(int) * word_.size() + sizeof(float) * scale_.size();
  }

 private:
  /// First word of a tile.
  [[nodiscard]] static std::size_t tile_start(const Panel& panel, int tile);

  std::vector<int> word_;
  std::vector<float> scale_;
};

}  // namespace tandem::fem
