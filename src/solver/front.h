#pragma once
// The dense front of frontal.h and the pivots that left it.

#include <span>
#include <vector>

namespace jaculus::solver {

/// Upper triangle of a symmetric matrix, column by column, over places 0 ... count - 1 that hold
/// unknowns. Candidates for pivots stand last, so that eliminating one shortens every column.
class Front {
 public:
  /// Forgets all unknowns and pivots; `size` is the number of unknowns there are.
  void clear(int size);

  /// Adds unknowns at zero: `enter` stay for later, `due` and those among the present ones that
  /// `is_due` are candidates from now on.
  void admit(const std::vector<int>& enter, const std::vector<int>& due,
             const std::vector<char>& is_due);

  [[nodiscard]] int place(int unknown) const { return place_[unknown]; }
  [[nodiscard]] int count() const { return count_; }
  void add(int unknown_a, int unknown_b, double value);
  /// Adds scale * line line^T of kLines lines, one after the other, each with a value a place.
  static constexpr int kLines = 4;
  void add_squares(std::span<const double> lines, std::span<const double, kLines> scales);

  /// Eliminates the candidates that have a pivot. With `all`, those whose pivot is worse as well;
  /// zero ones are left out and counted.
  struct Outcome {
    int negative = 0;
    int zero = 0;
  };
  Outcome eliminate(double threshold, bool all);

  /// rhs := D^-1 L^-1 rhs, then L^-T of that.
  void reduce(std::span<double> rhs) const;
  void restore(std::span<double> rhs) const;

 private:
  /// One unknown, or two, with the columns of L over the places before them.
  struct Pivot {
    int first = 0, second = -1;        ///< unknowns
    int length = 0;                    ///< places before it
    std::size_t ids = 0, at = 0;       ///< in ids_, columns_
    double d11, d21 = 0.0, d22 = 0.0;  ///< inverse of D's block
  };
  double* column(int j) { return data_.data() + static_cast<std::size_t>(j) * stride_; }
  void reserve(int places);
  void swap(int a, int b);
  /// Largest entries of the row and column of place p beside p and `but`.
  double largest_beside(int p, int but);
  bool take_single(int p, double threshold);
  bool take_pair(int p, int q, double threshold);
  bool take_each(double threshold);
  int find_partner(int p);
  void record(Pivot pivot);
  void eliminate_single();
  void eliminate_pair();

  std::vector<double> data_, spare_;  ///< stride_ by stride_, upper triangles
  std::vector<int> order_, from_;     ///< of admit(): unknowns by new places, their old places
  int stride_ = 0, count_ = 0, candidates_ = 0;
  std::vector<int> unknown_;  ///< of a place
  std::vector<int> place_;    ///< of an unknown, -1 where it is not in the front
  std::vector<Pivot> pivots_;
  std::vector<int> ids_;
  std::vector<double> columns_;
  Outcome outcome_;
};

}  // namespace jaculus::solver
