// A ROS 1 client for the tests that shares no code with rospy.
//
//   node client.cjs TOPIC...    prints each message as a line of JSON: topic, type, md5, at (s), data
//
// Lines of JSON on its input, {"topic": ..., "type": ..., "definition": ..., "data": ...}, are published;
// {"topic": ..., "flood": N} publishes N strings a second besides.
const { createServer } = require("node:net");
const { createInterface } = require("node:readline");
const { RosNode } = require("@foxglove/ros1");
const { TcpServerNode, TcpSocketNode } = require("@foxglove/ros1/nodejs");
const { HttpServerNodejs } = require("@foxglove/xmlrpc/nodejs");

const say = (line) => process.stdout.write(JSON.stringify(line) + "\n");

// Publish strings that are no command, so many a second, until the end.
function flooding(node, topic, perSecond) {
  const begun = Date.now();
  let said = 0;
  setInterval(() => {
    for (; said < ((Date.now() - begun) / 1000) * perSecond; said++) {
      node.publish(topic, { data: `garbage ${said}` });
    }
  }, 5);
}

async function main() {
  const server = createServer();
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  const node = new RosNode({
    name: `/client_${process.pid}`,
    rosMasterUri: process.env.ROS_MASTER_URI,
    hostname: "127.0.0.1",
    pid: process.pid,
    httpServer: new HttpServerNodejs(),
    tcpSocketCreate: TcpSocketNode.Create,
    tcpServer: new TcpServerNode(server),
  });
  await node.start();
  for (const topic of process.argv.slice(2)) {
    node.subscribe({ topic, dataType: "*" }).on("message", (data, _bytes, publisher) => {
      const header = publisher.connection.header();
      const [type, md5] = [header.get("type"), header.get("md5sum")];
      say({ topic, type, md5, at: Date.now() / 1000, data });
    });
  }
  for await (const line of createInterface({ input: process.stdin })) {
    const { topic, type, definition, data, flood } = JSON.parse(line);
    if (flood) {
      flooding(node, topic, flood);
      continue;
    }
    if (!node.isAdvertising(topic)) {
      await node.advertise({ topic, dataType: type, messageDefinitionText: definition });
    }
    if (data !== undefined) {
      await node.publish(topic, data);
    }
  }
  node.shutdown();
  process.exit(0);
}

main();
