// The WebSocket to the server that gave out this page; it comes back by itself when the server does.
import type { Answer, Request } from "./messages";

export interface Link {
  send(request: Request): void;
}

const PATIENCE_MS = [200, 500, 1000, 2000];

export function connect(hear: (answer: Answer) => void, state: (open: boolean) => void): Link {
  let socket: WebSocket | null = null;
  let tries = 0;
  const open = () => {
    const address = new URL("talk", document.baseURI);
    address.protocol = "ws:";
    socket = new WebSocket(address);
    socket.onopen = () => { tries = 0; state(true); };
    socket.onmessage = event => hear(JSON.parse(event.data as string) as Answer);
    socket.onclose = () => {
      state(false);
      setTimeout(open, PATIENCE_MS[Math.min(tries++, PATIENCE_MS.length - 1)]);
    };
  };
  open();
  return {
    send(request) {
      if (socket?.readyState === WebSocket.OPEN) socket.send(JSON.stringify(request));
    },
  };
}
