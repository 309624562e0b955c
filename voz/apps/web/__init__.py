"""The operator page: shows a run in any browser, drives the robot, and listens to the browser.

control loop ──▶ EventQueue ──▶ PageRegistry ──▶ pages (WebSockets)      on the server's thread
Inbox ◀── commands, stop ◀── CommandBridge ◀── PageRegistry ◀── pages
Hearing ◀── BrowserMicrophone ◀── sound of the driving page
"""
