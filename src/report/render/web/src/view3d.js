// A robot's URDF moving along a plan or a log in three dimensions: three.js and a kept URDF loader, one file, no request.

import './report.css';
import './view3d.css';
import {
  AmbientLight, Box3, Color, DirectionalLight, GridHelper, Group, LoadingManager, PerspectiveCamera, Scene, Vector3, WebGLRenderer,
} from 'three';
import { OrbitControls } from 'three/examples/jsm/controls/OrbitControls.js';
import URDFLoader from 'urdf-loader';
import { makeClock, makeControls } from './clock.js';
import { element, readData } from './data.js';
import { frameAt } from './frames.js';
import { colour, onTheme, paletteColour } from './theme.js';

/** The robot as its URDF draws it. Files that a URDF names are not here: such shapes stay empty. */
function loadRobot(urdf) {
  const missing = [];
  const loader = new URDFLoader(new LoadingManager());
  loader.loadMeshCb = (path, manager, done) => {
    missing.push(path);
    done(new Group());
  };
  return [loader.parse(urdf), missing];
}

/** Shapes without a colour of their own get one by the chain of links that they hang on: the base's children differ. */
function paint(robot) {
  const chains = new Map();
  robot.traverse((shape) => {
    if (!shape.isMesh || shape.material.color.getHex() !== 0xffffff) return;
    let chain = '';
    for (let up = shape.parent; up && up !== robot; up = up.parent) if (up.isURDFJoint) chain = up.name;
    if (!chains.has(chain)) chains.set(chain, chains.size);
    shape.material = shape.material.clone();
    shape.material.color.set(paletteColour(chain === '' ? 0 : chains.get(chain) % 2 ? 1 : 2));
  });
}

function light(scene) {
  scene.add(new AmbientLight(0xffffff, 1.2));
  const sun = new DirectionalLight(0xffffff, 2.2);
  sun.position.set(-1, -2, 3);
  scene.add(sun);
}

function floor(scene) {
  const grid = new GridHelper(6, 30, 0x888888, 0xbbbbbb);
  grid.rotation.x = Math.PI / 2;  // z is up here
  scene.add(grid);
  return grid;
}

function build(data) {
  const main = document.getElementById('report');
  main.append(element('h1', '', data.title), element('p', 'caption', data.caption));
  const time = data.array(data.time);
  const base = ['x', 'z', 'pitch'].map((name) => data.array(data.base[name]));
  const joints = Object.entries(data.joints).map(([name, index]) => [name, data.array(index)]);
  const clock = makeClock(time[0], time[time.length - 1]);
  main.append(makeControls(clock));
  const stage = element('div', 'stage3d');
  main.append(stage);
  const [robot, missing] = loadRobot(data.urdf);
  if (missing.length) main.append(element('p', 'notice', `Shapes from ${missing.length} files are not drawn.`));
  window.jaculusView = { clock, robot, drawn: 0 };
  let renderer;
  try {
    renderer = new WebGLRenderer({ antialias: true, preserveDrawingBuffer: true });
  } catch (error) {
    stage.append(element('p', 'notice', 'This browser has no WebGL, which the picture needs.'));
    document.documentElement.classList.add('ready');
    return;
  }
  stage.append(renderer.domElement);
  const scene = new Scene();
  light(scene);
  floor(scene);
  paint(robot);
  scene.add(robot);
  const camera = new PerspectiveCamera(40, 1, 0.01, 100);
  camera.up.set(0, 0, 1);
  const controls = new OrbitControls(camera, renderer.domElement);
  const draw = () => {
    scene.background = new Color(colour('--raised'));
    renderer.render(scene, camera);
    window.jaculusView.drawn += 1;
  };
  const place = (t) => {
    const [frame, share] = frameAt(time, t);
    const next = Math.min(frame + 1, time.length - 1);
    const at = (values) => values[frame] + share * (values[next] - values[frame]);
    robot.position.set(at(base[0]), 0, at(base[1]));
    robot.rotation.set(0, at(base[2]), 0);
    for (const [name, values] of joints) robot.setJointValue(name, at(values));
  };
  const pose = (t) => {
    place(t);
    draw();
  };
  // The camera sees the whole motion.
  const box = new Box3();
  for (let k = 0; k <= 10; k++) {
    place(clock.from + ((clock.to - clock.from) * k) / 10);
    robot.updateMatrixWorld(true);
    box.union(new Box3().setFromObject(robot));
  }
  const middle = box.getCenter(new Vector3());
  const away = 0.75 * box.getSize(new Vector3()).length() + 0.3;
  camera.position.copy(middle).add(new Vector3(0.45 * away, -1.2 * away, 0.35 * away));
  controls.target.copy(middle);
  controls.update();
  const resize = () => {
    const { clientWidth, clientHeight } = stage;
    renderer.setPixelRatio(devicePixelRatio);
    renderer.setSize(clientWidth, clientHeight, false);
    camera.aspect = clientWidth / Math.max(1, clientHeight);
    camera.updateProjectionMatrix();
    draw();
  };
  controls.addEventListener('change', draw);
  new ResizeObserver(resize).observe(stage);
  onTheme(draw);
  resize();
  clock.follow(pose);
  document.documentElement.classList.add('ready');
}

build(readData('data'));
