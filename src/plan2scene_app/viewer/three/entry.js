// The parts of three.js that the viewer uses: `npm ci && npm run build` makes ../three.min.js from them.
export {
  Box3,
  BufferGeometry,
  DoubleSide,
  Float32BufferAttribute,
  FrontSide,
  LineBasicMaterial,
  LineSegments,
  LinearMipmapNearestFilter,
  Mesh,
  MeshBasicMaterial,
  NoColorSpace,
  PerspectiveCamera,
  Points,
  PointsMaterial,
  Quaternion,
  Raycaster,
  Scene,
  Sphere,
  Texture,
  Triangle,
  Vector2,
  Vector3,
  Vector4,
  WebGLRenderer,
} from "three";
export { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
export { GLTFLoader } from "three/examples/jsm/loaders/GLTFLoader.js";
export { Capsule } from "three/examples/jsm/math/Capsule.js";
export { Octree } from "three/examples/jsm/math/Octree.js";
