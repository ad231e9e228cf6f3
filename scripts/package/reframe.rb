class Reframe < Formula
  desc "Renders camera animations that share their paths between frames"
  homepage "https://localhost/reframe" # of a release: where it is
  url "file://#{__dir__}/reframe-1.0.0.tar.gz"
  license "Apache-2.0"

  depends_on "cmake" => :build
  depends_on "pkgconf" => :build
  depends_on "assimp"
  depends_on "draco"
  depends_on "embree"
  depends_on "fftw"
  depends_on "imath"
  depends_on "jansson"
  depends_on "jpeg-turbo"
  depends_on "libmicrohttpd"
  depends_on "libpng"
  depends_on :linux # until it has been built on macOS
  depends_on "opencolorio"
  depends_on "openexr"
  depends_on "webp"
  uses_from_macos "zlib"

  resource "stb" do # headers alone
    url "https://github.com/nothings/stb.git", branch: "master"
  end

  def install
    resource("stb").stage buildpath/"include/stb"
    system "cmake", "-S", ".", "-B", "build", "-DREFRAME_MARCH=", "-DREFRAME_TESTS=OFF",
           "-DSTB_INCLUDE_DIR=#{buildpath}/include", *std_cmake_args
    system "cmake", "--build", "build"
    system "cmake", "--install", "build"
  end

  test do
    assert_match version.to_s, shell_output("#{bin}/reframe --version")
  end
end
