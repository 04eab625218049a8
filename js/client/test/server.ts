// A real server for the tests: halfphysics serve, in a process of its own.

import { spawn, type ChildProcess } from "node:child_process";

export interface Served {
  url: string;
  stop(signal?: NodeJS.Signals): Promise<void>;
}

/** The command that serves; a test of the Python package gives its own interpreter. */
function command(): string[] {
  const given = process.env["HALFPHYSICS_SERVE"];
  if (given) return JSON.parse(given) as string[];
  return ["python3", "-m", "halfphysics", "serve"];
}

export async function serve(...options: string[]): Promise<Served> {
  const [program, ...rest] = command();
  const child = spawn(program!, [...rest, ...options], { stdio: ["ignore", "pipe", "pipe"] });
  const url = await address(child);
  return {
    url,
    async stop(signal = "SIGINT") {
      if (child.exitCode !== null || child.signalCode !== null) return;
      const ended = new Promise<void>((resolve) => child.once("exit", () => resolve()));
      child.kill(signal);
      await ended;
    },
  };
}

function address(child: ChildProcess): Promise<string> {
  return new Promise((resolve, reject) => {
    let said = "";
    const listen = (chunk: Buffer): void => {
      said += chunk.toString();
      const found = /wss?:\/\/[^\s,]+/.exec(said);
      if (found) resolve(found[0]);
    };
    child.stdout!.on("data", listen);
    child.stderr!.on("data", (chunk: Buffer) => (said += chunk.toString()));
    child.once("exit", (code) => reject(new Error(`the server ended with ${code}: ${said}`)));
    child.once("error", reject);
  });
}
