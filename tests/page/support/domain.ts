import {type Socket, createSocket} from "node:dgram";
import {once} from "node:events";
import {readFileSync} from "node:fs";

// Like tests/support/test_domain.cpp, so that neither takes a domain that the other has.
const kPorts = new URL("../../../common/dds/ports.h", import.meta.url);
const kTopics = new URL("../../../common/dds/topics.h", import.meta.url);

/// Reads a constant of a C++ header.
function constant(header: URL, name: string): number {
  const found = new RegExp(`\\b${name} = (\\d+);`).exec(readFileSync(header, "utf8"));
  if (!found) throw new Error(`${header.pathname} has no ${name}`);
  return Number(found[1]);
}

/// Returns a socket that has the port to itself; undefined if the port is taken.
async function take(port: number): Promise<Socket | undefined> {
  const socket = createSocket("udp4");
  try {
    socket.bind({port, exclusive: true});
    await once(socket, "listening");
    return socket;
  } catch {
    socket.close();
    return undefined;
  }
}

/// Claims a `--domain` that nothing else on this host uses, until this process ends.
export async function ownDomain(): Promise<string> {
  const gain = constant(kPorts, "kPortsPerDomain");
  const first = (domainId: number): number => constant(kPorts, "kFirstPort") + gain * domainId;
  const nobodyIn = async (domainId: number): Promise<boolean> => {
    const discovery = await take(first(domainId));
    discovery?.close();
    return discovery !== undefined;
  };
  for (let domain = 1; domain < constant(kTopics, "kMaxDomain"); ++domain) {
    const claim = await take(first(2 * domain) + gain - 1);
    if (!claim) continue;
    if ((await nobodyIn(2 * domain)) && (await nobodyIn(2 * domain + 1))) {
      claim.unref();
      return String(domain);
    }
    claim.close();
  }
  throw new Error("no --domain is free on this host for a test");
}
