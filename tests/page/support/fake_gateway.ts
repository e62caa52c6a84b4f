import {createHash} from "node:crypto";
import {existsSync, readFileSync} from "node:fs";
import {createServer, type IncomingMessage, type Server, type ServerResponse} from "node:http";
import type {AddressInfo} from "node:net";
import {extname, join} from "node:path";
import {fileURLToPath} from "node:url";

import {parseIDL} from "@foxglove/omgidl-parser";
import {MessageWriter} from "@foxglove/omgidl-serialization";
import {FoxgloveServer, type IWebSocket} from "@foxglove/ws-protocol";
import {type WebSocket, WebSocketServer} from "ws";

import {kIdentity} from "@page/base/pose";
import type {Channel} from "@page/protocol/decoder";
import type {ToolState} from "@page/protocol/messages";

const kZero = [0, 0, 0] as const;
const kRoot = fileURLToPath(new URL("../../..", import.meta.url));
const kPage = join(kRoot, "build/page");
const kTypes: Readonly<Record<string, string>> = {
  ".html": "text/html; charset=utf-8",
  ".js": "text/javascript",
  ".css": "text/css",
};

const kIdl = (name: string): string => readFileSync(join(kRoot, `idl/${name}.idl`), "utf8");

const cdrChannel = (name: string, type: string, idl: string): Omit<Channel, "id"> => ({
  ...{topic: `/palpate/${name}`, encoding: "cdr"},
  ...{schemaName: `palpate::${type}`, schema: kIdl(idl)},
});
const jsonChannel = (name: string): Omit<Channel, "id"> => ({
  ...{topic: `/palpate/${name}`, encoding: "json", schemaName: "", schema: ""},
});

const kOfCourse = [
  ...["me", "people", "class_answer", "exercises", "trial_state", "exam_state", "exam_answer"],
].map(jsonChannel);
const kReplayAnswer = jsonChannel("replay_answer");

export const kChannels: readonly Channel[] = [
  cdrChannel("tool_state", "ToolState", "teaching"),
  cdrChannel("loop_statistics", "LoopStatistics", "teaching"),
  cdrChannel("session_state", "SessionState", "session"),
  cdrChannel("station_statistics", "StationStatistics", "teaching"),
  cdrChannel("scene_whole", "SceneWhole", "session"),
  cdrChannel("solid_block", "SolidBlock", "solid"),
  ...["mouse_state", "replay_contents", "replay_state", "goal"].map(jsonChannel),
  kReplayAnswer,
  ...kOfCourse,
].map((channel, i) => ({...channel, id: i + 1}));

const kWriters = new Map(
  kChannels
    .filter((channel) => channel.encoding === "cdr")
    .map((channel) => [
      channel.topic,
      new MessageWriter(channel.schemaName, parseIDL(channel.schema)),
    ]),
);

/// A message as the server's DDS would put it on the wire.
export function encode(topic: string, value: object): Uint8Array {
  const writer = kWriters.get(topic);
  return writer ? writer.writeMessage(value) : new TextEncoder().encode(JSON.stringify(value));
}

/// A tool state as it is sent, from what the page should read.
export function toolState(state: Partial<ToolState>): object {
  const {haptic = kIdentity, graphic = kIdentity, points = [], poseSequence = 0} = state;
  const {forceN = kZero, torqueNm = kZero, ...named} = state;
  return {
    ...named,
    pose_sequence: BigInt(poseSequence),
    haptic_position_m: [...haptic.p],
    haptic_orientation_wxyz: [...haptic.q],
    graphic_position_m: [...graphic.p],
    graphic_orientation_wxyz: [...graphic.q],
    force_N: [...forceN],
    torque_Nm: [...torqueNm],
    step_us: 9.5,
    contacts: points.length,
    points: points.length,
    point: Array.from({length: 16}, (_, i) => ({
      position_m: [...(points[i]?.positionM ?? kZero)],
      force_N: [...(points[i]?.forceN ?? kZero)],
    })),
  };
}

/// A state in which the ball presses on the box of the test's scene.
export const pressed = (station: string, poseSequence: number, newtons: number, x = 0): object =>
  toolState({
    ...{station, scene: "test-box", tool: "ball", poseSequence},
    haptic: {...kIdentity, p: [x, 0.037 - newtons / 1000, 0]},
    graphic: {...kIdentity, p: [x, 0.037, 0]},
    forceN: [0, newtons, 0],
    points: newtons > 0 ? [{positionM: [x, 0.025, 0], forceN: [0, newtons, 0]}] : [],
  });

const kPhases = ["waiting", "acquiring", "active", "refused", "ended", "held"];

export function sessionState(
  station: string,
  phase: string,
  scene: string,
  tool: string,
  {reason = "", serverRun = 1n, muted = false} = {},
): object {
  return {
    station,
    run: 1n,
    server_run: serverRun,
    phase: kPhases.indexOf(phase),
    muted,
    scene,
    tool,
    reason,
    // The writer has no default for lists of a fixed length.
    tool_reference_m: [0, 0, 0],
    start_position_m: [0, 0, 0],
    start_orientation_wxyz: [1, 0, 0, 0],
  };
}

export function loopStatistics(station: string, scene: string, more: object = {}): object {
  return {
    station,
    scene,
    steps: 1000n,
    rate_hz: 1000,
    step_us_p50: 9.1,
    step_us_p99: 14.2,
    step_us_p999: 22.8,
    ...more,
  };
}

export function stationStatistics(station: string, more: object = {}): object {
  return {
    station,
    device: "PHANTOM Premium 3.0",
    ticks: 1000n,
    replies: 1000n,
    silence_s_max: 0.0012,
    wanted_force_N_max: 2,
    applied_force_N_max: 2,
    energy_J: 0.0125,
    warmth: 0.21,
    device_status: 1,
    ...more,
  };
}

/// A gateway that speaks to the page as palpate-viewer does, and sends what a test wants.
export class FakeGateway {
  /// Given to each client that subscribes: what is transient-local at a real one.
  readonly retained: {topic: string; value: object}[] = [];
  readonly published: Record<string, unknown>[] = []; // what clients sent on their channels
  health: object = {}; // reported besides its scenes
  readonly files = new Map<string, string>(); // others that it has, by path
  takesMessages = true;
  allowsSteering = true; // of a replay
  hasCourse = false;
  turnsAway = false; // refuses every client
  role = ""; // of each client; empty: none, as in gateways before there were roles
  token = ""; // required for all but the page's files; empty: none
  /// Called with what a client sent; may return why the gateway refuses it.
  onPublish: (message: Record<string, unknown>) => string | void = () => {};
  private readonly http: Server;
  private readonly sockets: WebSocketServer;
  private readonly clients = new Set<(topic: string, value: object) => void>();
  // Kept after it has stopped, for the next one: the browser has compiled the page of that address.
  port = 0;

  private constructor(private readonly scenes: ReadonlyMap<string, Uint8Array>) {
    this.http = createServer((request, response) => this.serve(request, response));
    this.sockets = new WebSocketServer({
      server: this.http,
      verifyClient: ({req}: {req: IncomingMessage}) => {
        const offered = req.headers["sec-websocket-protocol"]?.split(/, */) ?? [];
        const isKnown = this.token === "" || offered.includes(`palpate.token.${this.token}`);
        return isKnown && !this.turnsAway;
      },
      handleProtocols: (offered) => new FoxgloveServer({name: ""}).handleProtocols(offered),
    });
    this.sockets.on("connection", (socket) => this.connected(socket));
  }

  /// @param port  0: any
  static async start(scenes: ReadonlyMap<string, Uint8Array>, port = 0): Promise<FakeGateway> {
    const gateway = new FakeGateway(scenes);
    await new Promise<void>((resolve, reject) => {
      gateway.http.once("error", reject);
      gateway.http.listen(port, "127.0.0.1", resolve);
    });
    gateway.port = (gateway.http.address() as AddressInfo).port;
    return gateway;
  }

  async stop(): Promise<void> {
    for (const client of this.sockets.clients) client.terminate();
    this.http.closeAllConnections();
    this.sockets.close();
    await new Promise((resolve) => this.http.close(resolve));
  }

  get url(): string {
    return `http://127.0.0.1:${this.port}/`;
  }

  send(topic: string, value: object): void {
    for (const sendTo of this.clients) sendTo(topic, value);
  }
  retain(topic: string, value: object): void {
    this.retained.push({topic, value});
    this.send(topic, value);
  }

  private has(topic: string): boolean {
    const isOf = (one: {topic: string}): boolean => one.topic === topic;
    if (isOf(kReplayAnswer)) return this.allowsSteering;
    return this.hasCourse || !kOfCourse.some(isOf);
  }

  /// A server of its own, since what it offers may change from one page to the next.
  private connected(socket: WebSocket): void {
    const server = new FoxgloveServer({
      name: "fake gateway",
      capabilities: this.takesMessages ? ["clientPublish"] : [],
      supportedEncodings: ["json"],
      ...(this.role === "" ? {} : {metadata: {role: this.role}}),
    });
    const topics = kChannels.filter(({topic}) => this.has(topic));
    const ids = new Map(topics.map((channel) => [channel.topic, server.addChannel(channel)]));
    const send = (topic: string, value: object): void => {
      const id = ids.get(topic);
      if (id === undefined) return;
      server.sendMessage(id, process.hrtime.bigint(), new Uint8Array(encode(topic, value)));
    };
    server.on("subscribe", (id) => {
      for (const {topic, value} of this.retained) if (ids.get(topic) === id) send(topic, value);
    });
    server.on("message", ({data}) => {
      const message = JSON.parse(new TextDecoder().decode(data)) as Record<string, unknown>;
      this.published.push(message);
      const refusal = this.onPublish(message);
      if (refusal) server.sendStatus({level: 2, message: refusal});
    });
    server.handleConnection(socket as unknown as IWebSocket, "page");
    this.clients.add(send);
    socket.on("close", () => this.clients.delete(send));
  }

  private serve(request: IncomingMessage, response: ServerResponse): void {
    const path = new URL(request.url ?? "/", "http://localhost").pathname;
    const isGuarded = path === "/healthz" || path.startsWith("/scene/");
    const bears = this.token === "" || request.headers.authorization === `Bearer ${this.token}`;
    if (isGuarded && !bears) {
      response.writeHead(401).end();
      return;
    }
    const scene = /^\/scene\/(.+)\.bundle$/.exec(path)?.[1];
    if (scene !== undefined) {
      this.serveScene(request, response, decodeURIComponent(scene));
      return;
    }
    if (path === "/healthz") {
      const usual = {server_run: "0", server_lives: true, compiling: null};
      const said = {...usual, viewers: 1, max_viewers: 300, scenes: [...this.scenes.keys()]};
      response.end(JSON.stringify({...said, ...this.health}));
      return;
    }
    const text = this.files.get(path);
    if (text !== undefined) {
      response.end(text);
      return;
    }
    const file = join(kPage, path === "/" ? "index.html" : path);
    if (!file.startsWith(kPage) || !existsSync(file)) {
      response.writeHead(404).end();
      return;
    }
    const packed = existsSync(`${file}.gz`);
    response.writeHead(200, {
      "Content-Type": kTypes[extname(file)] ?? "application/octet-stream",
      ...(packed ? {"Content-Encoding": "gzip"} : {}),
    });
    response.end(readFileSync(packed ? `${file}.gz` : file));
  }

  private serveScene(request: IncomingMessage, response: ServerResponse, name: string): void {
    const bytes = this.scenes.get(name);
    const tag = bytes && `"${createHash("sha1").update(bytes).digest("hex")}"`;
    const isHad = tag !== undefined && request.headers["if-none-match"] === tag;
    response.writeHead(!tag ? 404 : isHad ? 304 : 200, tag ? {ETag: tag} : {});
    response.end(isHad ? undefined : bytes);
  }
}
